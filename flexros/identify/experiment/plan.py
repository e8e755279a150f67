"""The plan of an identification experiment: positions, periods, lines; the same for run, estimation and log."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError, source_named
from flexros.identify.experiment.slow_motion import SlowSine
from flexros.identify.experiment.timetable import Segment, Timing, Visit, segments_of, timing_of, visits_of

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray
    from flexros.identify.excitation.base import BlockSignals
    from flexros.identify.excitation.lines import Lines
    from flexros.identify.experiment.specification import IdentificationSpecification
    from flexros.robot import Robot

__all__ = ["ExperimentPlan", "Segment"]

LONGEST = 7200.0
"""Longest experiment [s]; a longer one is refused as a mistake (chosen)."""


@dataclass(frozen=True, eq=False)
class ExperimentPlan:
    """Timetable and excitation of an experiment, a function of specification, robot, sample time and seed.

    Attributes:
        specification: Specification of the experiment.
        sample_time: Time between two samples [s].
        seed: Seed of phases and detection lines.
        start: Gear angles at the start [rad or m], shape (M,).
        positions: Gear angles of the positions [rad or m], shape (Q, M).
        timing: Lengths in samples that all positions share.
        visits: The stays in the positions, in the order of time.
        segments: Recorded whole periods of every experiment, in the order of time.
        lines: Excited lines and detection lines.
    """

    specification: IdentificationSpecification
    sample_time: float
    seed: int
    start: FloatArray
    positions: FloatArray
    timing: Timing
    visits: tuple[Visit, ...]
    segments: tuple[Segment, ...]
    lines: Lines

    @classmethod
    def build(
        cls,
        specification: IdentificationSpecification,
        robot: Robot,
        sample_time: float,
        seed: int,
        start: FloatArray | None = None,
    ) -> ExperimentPlan:
        """Make the plan.

        Args:
            specification: Specification of the experiment.
            robot: The nominal robot.
            sample_time: Time between two samples [s].
            seed: Seed of phases and detection lines where the specification has none of its own.
            start: Gear angles at the start [rad or m], shape (M,); default: those of the robot's home pose.

        Returns:
            The plan.

        Raises:
            InputError: Positions, times or frequencies are not possible; the sentence names the key.
        """
        n_motors = robot.n_motors
        begin = robot.home[list(robot.gear_rows)] if start is None else start
        seed = seed if specification.seed is None else specification.seed
        specification.check_motors(n_motors)
        positions = specification.gears(n_motors)
        with source_named("identification"):
            timing = timing_of(specification, n_motors, sample_time)
            visits = visits_of(specification, timing, begin, n_motors, sample_time)
            lines = _without_sine(specification, specification.excitation.lines(sample_time, seed))
        segments = segments_of(visits, timing, specification)
        plan = cls(specification, sample_time, seed, begin, positions, timing, visits, segments, lines)
        if plan.duration > LONGEST:
            raise InputError(
                f"identification: the experiment lasts {plan.duration:.4g} s, allowed are at most {LONGEST:g} s; take "
                "fewer positions, blocks or periods"
            )
        return plan

    @property
    def n_motors(self) -> int:
        """Number of motors M, also that of experiments in a block."""
        return int(self.positions.shape[1])

    @property
    def n_samples(self) -> int:
        """Number of samples of the whole experiment."""
        return self.visits[-1].end + 1

    @property
    def duration(self) -> float:
        """Time of the last sample [s]."""
        return (self.n_samples - 1) * self.sample_time

    @property
    def period_samples(self) -> int:
        """Length of a period, or of a record from rest to rest [samples]."""
        return self.timing.period

    @property
    def periodic(self) -> bool:
        """Whether the recorded periods repeat; false: every period is a record from rest to rest."""
        return self.specification.excitation.periodic

    @property
    def excited_lines(self) -> IntArray:
        """Lines with energy, multiples of one over the period, shape (F,)."""
        return self.lines.excited

    @property
    def odd_detection_lines(self) -> IntArray:
        """Odd lines that were left empty, shape (n_odd,)."""
        return self.lines.odd_detection

    @property
    def even_detection_lines(self) -> IntArray:
        """Even lines that were left empty, shape (n_even,)."""
        return self.lines.even_detection

    @cached_property
    def frequency(self) -> FloatArray:
        """Excited frequencies [Hz], shape (F,)."""
        return np.asarray(self.excited_lines / (self.period_samples * self.sample_time), dtype=float)

    def signals(self, position: int, block: int) -> BlockSignals:
        """Give one period of the excitation of every experiment of a block, without slow motion and fades.

        Args:
            position: Number of the position.
            block: Number of the block in that position.

        Returns:
            Speed and position reference about the position, shape (n_experiments, period_samples, M).
        """
        return self.specification.excitation.block(self.n_motors, self.sample_time, self.seed, position, block)


def _without_sine(specification: IdentificationSpecification, lines: Lines) -> Lines:
    """Take the line of a slow sine out of the detection lines; refuse it among the excited ones."""
    motion = specification.slow_motion
    if not isinstance(motion, SlowSine):
        return lines
    if motion.cycles in lines.excited:
        raise InputError(
            f"slow_motion.cycles is {motion.cycles}, a line that the excitation uses, allowed is a line it leaves out, "
            "e.g. one below excitation.lowest; raise lowest or change cycles"
        )
    return lines.without(motion.cycles)
