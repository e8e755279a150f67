"""What to run next when a log leaves several explanations: the experiment that separates them best, by simulation."""

from __future__ import annotations

import json
import shlex
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING

from flexros.effects import RobotWithEffects
from flexros.errors import RunError
from flexros.gap.next_experiment.catalogue import CATALOGUE
from flexros.gap.next_experiment.separation import Explained, separation, trial
from flexros.gap.schema import EffectLocation, NextExperiment

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Mapping, Sequence
    from typing import Any

    from flexros.effects import PlacedEffect
    from flexros.gap.next_experiment.catalogue import CatalogueEntry
    from flexros.robot import Robot

SEED = 101
"""Seed of the experiments that are simulated and proposed [1] (chosen: another one than a user takes first)."""
MOST = 3
"""Explanations that are looked at, the most probable ones [1] (chosen)."""
PLENTY = 100.0
"""Gain at which no further experiment is looked at [nats] (chosen: far beyond doubt)."""
ENOUGH = 0.5
"""An experiment earlier in the catalogue is taken when it separates at least this share of the best [1] (chosen)."""


@dataclass(frozen=True)
class Separated:
    """What an experiment of the catalogue would do.

    Attributes:
        entry: The experiment.
        gain: Expected logarithm of the odds of the two closest explanations, either being true as likely as the other
            [nats].
        closest: Numbers of those two in the list of explanations.
    """

    entry: CatalogueEntry
    gain: float
    closest: tuple[int, int]


def next_experiment(
    robot: Robot | RobotWithEffects,
    survivors: Sequence[Sequence[PlacedEffect]],
    *,
    name: str = "",
    tool_measured: bool = False,
    tolerance: Mapping[str, float] | None = None,
    done: Collection[str] = (),
    seed: int = SEED,
    entries: Sequence[CatalogueEntry] = CATALOGUE,
    progress: Callable[[float], None] | None = None,
) -> NextExperiment | None:
    """Choose the experiment that separates the two closest explanations best, or the plainest that does so by far.

    Args:
        robot: The nominal model.
        survivors: Explanations that are left with their fitted numbers, the most probable one first.
        name: Robot as the user names it, for the command; default: where it was loaded from.
        tool_measured: Whether the log has tool positions already, so that measuring them is no news.
        tolerance: Relative tolerance of stiffness, inertia and damping [1]; default: those of the robot file.
        done: Names of experiments that were run already.
        seed: Seed of the experiments.
        entries: Experiments to choose from.
        progress: Called with the share that is done.

    Returns:
        The experiment; None where there are fewer than two explanations, or none of the experiments can be run.
    """
    model = robot if isinstance(robot, RobotWithEffects) else RobotWithEffects(robot, ())
    left = [Explained(model, tuple(one), tolerance or {}) for one in survivors][:MOST]
    if len(left) < 2:
        return None
    chosen = [entry for entry in entries if entry.name not in done and not (entry.tool and tool_measured)]
    possible: list[Separated] = []
    for number, entry in enumerate(chosen, 1):
        result = separated(left, entry, seed)
        possible += [] if result is None else [result]
        plenty = result is not None and result.gain >= PLENTY
        if progress is not None:
            progress(1.0 if plenty else number / len(chosen))
        if plenty:
            break
    if not possible:
        return None
    most = max(one.gain for one in possible)
    best = next(one for one in possible if one.gain >= min(ENOUGH * most, PLENTY))
    command = command_of(best.entry.keys(model.robot), name or _name_of(model.robot), seed)
    places = {(one.effect.name, one.location): None for number in best.closest for one in left[number].placed}
    return NextExperiment(
        name=best.entry.name,
        description=best.entry.description,
        separates=tuple(EffectLocation(effect=effect, location=location) for effect, location in places),
        expected_gain=best.gain,
        command=command,
    )


def separated(survivors: Sequence[Explained], entry: CatalogueEntry, seed: int = SEED) -> Separated | None:
    """Simulate an experiment with every explanation and compare all of them.

    Args:
        survivors: Explanations of one nominal model with their fitted numbers, two at least.
        entry: The experiment.
        seed: Its seed.

    Returns:
        How well it separates the two closest; None where it would break off with one of them.
    """
    keys = entry.keys(survivors[0].model.robot)
    known = {key.removeprefix("model.values."): value for key, value in keys.items() if key.startswith("model.values.")}
    keys = {key: value for key, value in keys.items() if not key.startswith("model.values.")}
    explained = [one.with_values(known) for one in survivors]
    try:
        made = [trial(one, keys, seed, tool=entry.tool) for one in explained]
    except RunError:
        return None
    gains = {}
    for one, two in combinations(range(len(explained)), 2):
        there = separation(explained[one], explained[two], made[one])
        back = separation(explained[two], explained[one], made[two])
        gains[one, two] = 0.5 * (there + back)
    closest = min(gains, key=lambda pair: gains[pair])
    return Separated(entry, gains[closest], closest)


def command_of(keys: Mapping[str, Any], name: str, seed: int) -> str:
    """Write the command that runs an experiment.

    Args:
        keys: Keys of scenario `diagnosis` that differ, by dotted name.
        name: Robot as the user names it.
        seed: Seed of the experiment.

    Returns:
        A line for a shell.
    """
    words = ["flexros", "run", "diagnosis", "--model", name, "--seed", str(seed)]
    for key, value in keys.items():
        words += ["--set", f"{key}={json.dumps(value)}"]
    return shlex.join(words)


def _name_of(robot: Robot) -> str:
    """Name a robot as a command does: by the file that it came from, else by its name."""
    return robot.source if Path(robot.source).is_file() else robot.name
