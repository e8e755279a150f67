"""When an identification experiment does what, in samples."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.config.per_motor import per_motor
from flexros.identify.experiment.slow_motion import ConstantSpeed, NoSlowMotion
from flexros.trajectory import JointMove
from flexros.trajectory.polynomial import NINTH_DEGREE, peaks
from flexros.trajectory.time_law_specification import PolynomialSpecification

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.identify.experiment.specification import IdentificationSpecification, MoveSettings
    from flexros.trajectory import TimeLaw


@dataclass(frozen=True)
class Segment:
    """One experiment of a block: its recorded whole periods, without transients.

    Attributes:
        position: Number of the position.
        block: Number of the block in that position.
        experiment: Number of the experiment in that block.
        first: First recorded sample.
        n_periods: Number of recorded periods.
        period: Length of a period [samples].
    """

    position: int
    block: int
    experiment: int
    first: int
    n_periods: int
    period: int

    @property
    def stop(self) -> int:
        """Sample after the last recorded one."""
        return self.first + self.n_periods * self.period


@dataclass(frozen=True)
class Visit:
    """The stay in one position.

    Attributes:
        position: Number of the position.
        begin: Sample at which the move to it begins.
        arrive: Sample at which the move has ended.
        lead: Sample at which the approach to the start of a constant speed begins; `begin_first` where there is none.
        begin_first: Sample at which the first experiment begins.
        experiment: Length of an experiment [samples], fades and transients included.
        order: Number of the block and of the experiment in it, in the order of time.
        end: Sample after the last of the stay.
    """

    position: int
    begin: int
    arrive: int
    lead: int
    begin_first: int
    experiment: int
    order: tuple[tuple[int, int], ...]
    end: int

    @property
    def n_experiments(self) -> int:
        """Number of experiments of all blocks."""
        return len(self.order)


@dataclass(frozen=True)
class Timing:
    """Lengths that all positions share [samples].

    Attributes:
        period: Period or record.
        fade: Fading in, and fading out; 0 for records from rest to rest without slow motion.
        before: From the begin of an experiment to its first recorded sample.
        experiment: Whole experiment.
        settle: Rest after a move.
        lead: Approach of the start of a constant speed; 0 where there is none.
    """

    period: int
    fade: int
    before: int
    experiment: int
    settle: int
    lead: int


def timing_of(specification: IdentificationSpecification, n_motors: int, sample_time: float) -> Timing:
    """Turn the times of a specification into samples.

    Args:
        specification: Specification of the experiment.
        n_motors: Number of motors M.
        sample_time: Time between two samples [s].

    Returns:
        The lengths.

    Raises:
        InputError: A time is no whole number of samples, or too short.
    """
    excitation = specification.excitation
    period = excitation.record_samples(sample_time)
    moving = not isinstance(specification.slow_motion, NoSlowMotion)
    fade = max(round(specification.fade / sample_time), 1) if excitation.periodic or moving else 0
    transient = specification.transient_periods if excitation.periodic else 0
    before = fade + transient * period
    experiment = before + specification.periods * period + fade
    lead = 0
    if isinstance(specification.slow_motion, ConstantSpeed):
        half = half_travel(specification, n_motors, experiment - fade, sample_time)
        lead = samples_of(approach_law(specification, half), sample_time) if np.any(half) else 0
    return Timing(period, fade, before, experiment, round(specification.settle / sample_time), lead)


def half_travel(
    specification: IdentificationSpecification, n_motors: int, at_speed: int, sample_time: float
) -> FloatArray:
    """Return half the travel of an experiment at constant speed.

    Args:
        specification: Specification of the experiment, with a constant speed.
        n_motors: Number of motors M.
        at_speed: Length of the experiment less one fade [samples].
        sample_time: Time between two samples [s].

    Returns:
        Half the way of every motor [rad or m], shape (M,).
    """
    assert isinstance(specification.slow_motion, ConstantSpeed)
    return 0.5 * at_speed * sample_time * specification.slow_motion.speeds(n_motors)


def move_law(start: FloatArray, end: FloatArray, settings: MoveSettings) -> TimeLaw:
    """Make the time law of a joint move: the share of the way from 0 to 1.

    Args:
        start: Where it begins [rad or m], shape (M,).
        end: Where it ends, another point, shape (M,).
        settings: Largest speed and acceleration.

    Returns:
        The law.

    Raises:
        InputError: The settings have another number of joints.
    """
    law = PolynomialSpecification(type="ninth_degree", speed=settings.speed, acceleration=settings.acceleration)
    return law.law(JointMove(start, end), joints=True)


def approach_law(specification: IdentificationSpecification, half: FloatArray) -> TimeLaw:
    """Make the time law of the way to the start of a constant speed.

    It accelerates no more than the fade does, because no feedforward torque helps there.

    Args:
        specification: Specification of the experiment, with a constant speed.
        half: The way of every motor [rad or m], not all zero, shape (M,).

    Returns:
        The law of the share of the way from 0 to 1.
    """
    assert isinstance(specification.slow_motion, ConstantSpeed)
    gentle = specification.slow_motion.speeds(half.size) * peaks(NINTH_DEGREE)[0] / specification.fade
    fastest = per_motor("identification.move.acceleration", specification.move.acceleration, half.size)
    acceleration = np.where(gentle > 0.0, np.minimum(gentle, fastest), fastest)
    settings = specification.move.model_copy(update={"acceleration": tuple(acceleration.tolist())})
    return move_law(np.zeros(half.size), half, settings)


def samples_of(law: TimeLaw, sample_time: float) -> int:
    """Return the number of samples in which a law has ended."""
    return int(np.ceil(law.duration / sample_time - 1e-6))


def visits_of(
    specification: IdentificationSpecification, timing: Timing, start: FloatArray, n_motors: int, sample_time: float
) -> tuple[Visit, ...]:
    """Lay the stays one after the other; positions without blocks are left out.

    Args:
        specification: Specification of the experiment.
        timing: Lengths in samples.
        start: Gear angles at the start [rad or m], shape (M,).
        n_motors: Number of motors M, also that of experiments in a block.
        sample_time: Time between two samples [s].

    Returns:
        The stays.
    """
    visits, here, at = [], start, 0
    gears = specification.gears(n_motors)
    for position, blocks in enumerate(specification.blocks_per_position):
        if not blocks:
            continue
        goal, moving = gears[position], 0
        if not np.array_equal(here, goal):
            moving = samples_of(move_law(here, goal, specification.move), sample_time)
        lead = at + moving + timing.settle
        first = lead + timing.lead
        order = order_of(blocks, n_motors, paired=isinstance(specification.slow_motion, ConstantSpeed))
        end = first + len(order) * timing.experiment + timing.lead
        visits.append(Visit(position, at, at + moving, lead, first, timing.experiment, order, end))
        here, at = goal, end
    return tuple(visits)


def order_of(n_blocks: int, n_motors: int, *, paired: bool) -> tuple[tuple[int, int], ...]:
    """Return the order of the experiments of a stay.

    With a constant speed whose sign changes from experiment to experiment, two blocks are run alternately: so all
    experiments of the one go forwards and all of the other backwards. A robot that leaves its position a little gives a
    response that drifts with the direction; within a block of one direction that does not mix the motors, and the mean
    of the two blocks has none of it (chosen).

    Args:
        n_blocks: Number of blocks.
        n_motors: Number of experiments in a block.
        paired: Whether blocks are run in pairs; a last one without partner is run by itself.

    Returns:
        Number of the block and of the experiment in it, one per experiment, in the order of time.
    """
    pairs = n_blocks // 2 if paired else 0
    order = [(2 * pair + side, e) for pair in range(pairs) for e in range(n_motors) for side in (0, 1)]
    return (*order, *((block, e) for block in range(2 * pairs, n_blocks) for e in range(n_motors)))


def segments_of(
    visits: tuple[Visit, ...], timing: Timing, specification: IdentificationSpecification
) -> tuple[Segment, ...]:
    """List the recorded periods of all experiments, in the order of time.

    Args:
        visits: The stays.
        timing: Lengths in samples.
        specification: Specification of the experiment.
    """
    return tuple(
        Segment(
            position=visit.position,
            block=block,
            experiment=experiment,
            first=visit.begin_first + number * timing.experiment + timing.before,
            n_periods=specification.periods,
            period=timing.period,
        )
        for visit in visits
        for number, (block, experiment) in enumerate(visit.order)
    )
