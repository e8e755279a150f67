"""Settings of the repetitions and their random numbers."""

from __future__ import annotations

from dataclasses import dataclass

EVALUATION_SEED = 10_000
"""First seed of the repetitions that are reported."""


@dataclass(frozen=True)
class CoverageSettings:
    """Settings of the check.

    Attributes:
        scenario: Built-in identification scenario; its robot is model and truth alike, encoder noise as in its file.
        positions: Number of positions, chosen by the D-optimal design.
        candidates: Number of positions to choose from.
        design_seed: Seed of candidates.
        repetitions: Number of repeated experiments.
        lanes: Repetitions that are simulated side by side; they have noise of their own but the same phases.
        groups_per_phase: Groups of lanes with the same phases.
        first_seed: Seed of the first phases; noise has seeds of its own above it.
        start_factor: Fits start at the truth times a random factor, log-uniform within this factor either way.
        starts: Fits from as many starts, of which the one of lowest cost counts.
    """

    scenario: str = "identify_six_axis"
    positions: int = 15
    candidates: int = 4000
    design_seed: int = 1
    repetitions: int = 200
    lanes: int = 8
    groups_per_phase: int = 1
    first_seed: int = EVALUATION_SEED
    start_factor: float = 3.0
    starts: int = 1

    @property
    def groups(self) -> tuple[RepetitionGroup, ...]:
        """The repetitions in groups that are computed together."""
        found = []
        for number, first in enumerate(range(0, self.repetitions, self.lanes)):
            members = range(first, min(first + self.lanes, self.repetitions))
            noise = tuple(self.first_seed * 1000 + member for member in members)
            found.append(RepetitionGroup(number, self.first_seed + number // self.groups_per_phase, noise))
        return tuple(found)


@dataclass(frozen=True)
class RepetitionGroup:
    """Repetitions that are simulated side by side.

    Attributes:
        number: Number of the group.
        phase_seed: Seed of the random phases and detection lines.
        noise_seeds: Seeds of the encoder noise and of the starts of the fits, one per repetition.
    """

    number: int
    phase_seed: int
    noise_seeds: tuple[int, ...]

    @property
    def name(self) -> str:
        """Name of the group, sorted as its number."""
        return f"group_{self.number:04d}"
