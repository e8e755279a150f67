"""From a robot to the positions of its identification experiment (Moberg 2007, Paper A, section 5.2)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.identify.design.candidates import candidate_positions
from flexros.identify.design.d_optimal import d_optimal
from flexros.identify.design.decay import decays_at
from flexros.identify.design.gain import design_gain
from flexros.identify.design.position_information import experiment_conditions, position_information
from flexros.identify.design.rounding import round_design
from flexros.identify.design.tour import short_tour

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import ArrayLike

    from flexros.arrays import FloatArray, IntArray
    from flexros.control.base import AbstractControlLaw
    from flexros.identify.design.candidates import CandidatePositions
    from flexros.identify.design.closed_loop_input import ExperimentConditions
    from flexros.identify.design.d_optimal import Design
    from flexros.identify.design.gain import DesignGain
    from flexros.identify.experiment.specification import IdentificationSpecification
    from flexros.robot import Robot

POSITIONS = 15
"""Positions by default, as in Moberg (2007), Paper A; fewer for robots with fewer unknown parameters."""
SETTLED = 9.0
"""Time constants of the loop's slowest motion after which its transient counts as gone, 1e-4 of it left (chosen)."""
SLOW = "the loop settles too slowly"
"""Why a candidate is left out, see `_settling`."""
FEWEST = 0.1
"""Share of the candidates that is kept even where the loop settles more slowly, the fastest ones (chosen)."""
PRIOR_DEVIATION = np.log(10.0)
"""Before the experiment a parameter is known within a factor of ten: one standard deviation of its logarithm (chosen,
as Paper A starts its fits within a factor of ten). It keeps a parameter that nothing determines from ruling the design.
"""


@dataclass(frozen=True)
class DesignSettings:
    """Settings of the choice of positions.

    Attributes:
        positions: Number of positions, or of shares of them where one may be taken more than once.
        candidates: Number of candidate positions.
        most: Most shares of one position; 1 makes all positions differ.
        distortion: Expected level of nonlinear distortions at the output relative to its own, rms [1].
        seed: Seed of candidates, excitation and random sets to compare with.
    """

    positions: int = POSITIONS
    candidates: int = 4000
    most: int | None = 1
    distortion: float = 0.0
    seed: int = 1


def default_positions(n_unknown: int) -> int:
    """Return the default number of positions for a number of unknown parameters."""
    return min(POSITIONS, n_unknown)


@dataclass(frozen=True, eq=False)
class ExperimentDesign:
    """The chosen positions, and what they were chosen from.

    Attributes:
        names: Names of the unknown parameters, length P.
        candidates: All positions that could have been chosen.
        conditions: Excitation and noise of one block.
        law: Controller of the experiment.
        sample_time: Time between two samples [s].
        design: The optimal shares and the information of one share (all blocks of a position), shape (Q, P, P).
        gain: The chosen positions compared with random ones.
        chosen: Chosen candidates in the order of a short tour from home, shape (S,).
        counts: How many shares each of them has, shape (S,).
    """

    names: tuple[str, ...]
    candidates: CandidatePositions
    conditions: ExperimentConditions
    law: AbstractControlLaw
    sample_time: float
    design: Design
    gain: DesignGain
    chosen: IntArray
    counts: IntArray

    @property
    def positions(self) -> FloatArray:
        """Gear coordinates of the chosen positions in order [rad or m], shape (S, M)."""
        return self.candidates.gears[self.chosen]

    @property
    def origin(self) -> str:
        """Describe the candidates of the choice, e.g. "400 of 4000 candidates (in the others the loop ...)"."""
        left, slow = len(self.candidates.gears), self.candidates.refused.get(SLOW, 0)
        return f"{left} of {left + slow} candidates (in the others {SLOW})" if slow else f"{left} candidates"

    @property
    def remark(self) -> str:
        """Describe a design whose optimum is a single position; empty for others."""
        if len(self.design.support) > 1 or len(self.chosen) == 1:
            return ""
        return (
            "The best experiment has a single position, to which others add nothing of their own: fewer positions with "
            "more blocks do as well."
        )

    @property
    def information(self) -> FloatArray:
        """Predicted information of the whole experiment about the logarithms of the parameters, shape (P, P)."""
        return np.asarray(np.tensordot(self.counts.astype(float), self.design.information[self.chosen], axes=1))


def design_experiment(
    robot: Robot,
    names: Sequence[str],
    specification: IdentificationSpecification,
    law: AbstractControlLaw,
    sample_time: float,
    settings: DesignSettings,
    ranges: ArrayLike | None = None,
    progress: Callable[[str, int, int], None] | None = None,
) -> ExperimentDesign:
    """Choose the most informative positions for the unknown parameters.

    Args:
        robot: The robot with its nominal values.
        names: Names of the unknown parameters, length P.
        specification: The experiment in each position; its own positions do not matter.
        law: Controller of the experiment.
        sample_time: Time between two samples [s].
        settings: How many positions, out of how many.
        ranges: Smallest and largest coordinate of each gear [rad or m], shape (M, 2); see `candidate_positions`.
        progress: Called with the current step, the amount done and the amount in all.

    Returns:
        The design.

    Raises:
        InputError: Ranges, excitation or names are not possible.
    """

    def report(step: str, total: int = settings.candidates) -> Callable[[int], None]:
        return lambda done: progress(step, done, total) if progress else None

    candidates = candidate_positions(robot, settings.candidates, ranges, settings.seed, report("candidate positions"))
    decays = decays_at(robot, candidates.motor_positions, law, sample_time, report("settling of the positions"))
    candidates = candidates.only(_settling(specification, sample_time, decays, settings.positions), SLOW)
    conditions = experiment_conditions(specification, robot, sample_time, settings.seed, distortion=settings.distortion)
    one_block = position_information(
        robot,
        names,
        candidates.motor_positions,
        conditions,
        law,
        sample_time,
        report("information of the positions", len(candidates.gears)),
    )
    information = max(specification.blocks_per_position) * one_block
    prior = np.eye(len(names)) / PRIOR_DEVIATION**2 / settings.positions
    design = d_optimal(information, prior)
    counts = round_design(design, settings.positions, settings.most)
    chosen = np.flatnonzero(counts)
    chosen = chosen[short_tour(robot.home[list(robot.gear_rows)], candidates.gears[chosen])]
    return ExperimentDesign(
        names=tuple(names),
        candidates=candidates,
        conditions=conditions,
        law=law,
        sample_time=sample_time,
        design=design,
        gain=design_gain(information, counts, design.log_det, settings.seed, prior=prior),
        chosen=chosen,
        counts=counts[chosen],
    )


def _settling(
    specification: IdentificationSpecification, sample_time: float, decays: FloatArray, positions: int
) -> IntArray:
    """Choose the positions where a transient is gone when recording begins, shape (Q',).

    What is left of a transient is an error that neither periods nor blocks average out. Where few positions settle in
    time the fastest are kept, and the experiment gets more transient periods.
    """
    excitation = specification.excitation
    if not excitation.periodic:
        return np.arange(len(decays))
    period = excitation.record_samples(sample_time) * sample_time
    time = specification.fade + specification.transient_periods * period
    fewest = max(int(np.ceil(FEWEST * len(decays))), min(positions, len(decays)))
    enough = min(SETTLED / time, np.sort(decays)[-fewest])
    return np.flatnonzero(decays >= enough)
