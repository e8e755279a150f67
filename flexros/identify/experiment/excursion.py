"""Excitation and slow motion that are added to the reference in a position."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.identify.excitation.window import window
from flexros.identify.experiment.slow_motion import ConstantSpeed, NoSlowMotion, SlowSine
from flexros.identify.experiment.timetable import approach_law, half_travel

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.identify.excitation.base import BlockSignals
    from flexros.identify.experiment.plan import ExperimentPlan
    from flexros.identify.experiment.timetable import Visit


@dataclass(frozen=True, eq=False)
class Excursion:
    """Motor motion about a position.

    Attributes:
        position: Added to the motor position [rad or m], shape (n, M).
        speed: Its exact derivative [rad/s or m/s], shape (n, M).
    """

    position: FloatArray
    speed: FloatArray


def excursion(plan: ExperimentPlan, visit: Visit) -> Excursion:
    """Return the motion of a stay, from the approach of a constant speed to the end of the last experiment and back.

    Args:
        plan: The plan.
        visit: The stay.

    Returns:
        The motion of the samples visit.lead to visit.end - 1; it is zero before and after.
    """
    n, m = visit.end - visit.lead, plan.n_motors
    result = Excursion(np.zeros((n, m)), np.zeros((n, m)))
    signals = {block: plan.signals(visit.position, block) for block in {block for block, _ in visit.order}}
    for number, (block, experiment) in enumerate(visit.order):
        first = visit.begin_first - visit.lead + number * visit.experiment
        rows = slice(first, first + visit.experiment)
        for part in (faded(plan, signals[block], experiment), _slow(plan, backwards=number % 2 == 1)):
            result.position[rows] += part.position
            result.speed[rows] += part.speed
    if plan.timing.lead:
        _add_approaches(plan, visit, result)
    return result


def faded(plan: ExperimentPlan, signals: BlockSignals, experiment: int) -> Excursion:
    """Return the excitation of one experiment, without slow motion.

    Args:
        plan: The plan.
        signals: Excitation of the block.
        experiment: Number of the experiment in the block.

    Returns:
        Periods that are faded in and out, or records from rest to rest, over the samples of the experiment.
    """
    timing = plan.timing
    k = np.arange(timing.experiment) - timing.fade
    moved, speed = signals.position[experiment][k % timing.period], signals.speed[experiment][k % timing.period]
    if plan.periodic:
        height, slope, _ = (part[:, None] for part in window(timing.experiment, timing.fade, plan.sample_time))
        return Excursion(height * moved, height * speed + slope * moved)
    outside = (k < 0) | (k >= plan.specification.periods * timing.period)
    moved[outside], speed[outside] = 0.0, 0.0
    return Excursion(moved, speed)


def _slow(plan: ExperimentPlan, *, backwards: bool) -> Excursion:
    """Return the slow motion of one experiment; a constant speed begins and ends half its way from the position."""
    timing, motion, time = plan.timing, plan.specification.slow_motion, plan.sample_time
    if isinstance(motion, NoSlowMotion):
        return Excursion(np.zeros((timing.experiment, plan.n_motors)), np.zeros((timing.experiment, plan.n_motors)))
    height, slope, area = (part[:, None] for part in window(timing.experiment, timing.fade, time))
    speed = motion.speeds(plan.n_motors)
    if isinstance(motion, ConstantSpeed):
        sign = -1.0 if backwards else 1.0
        return Excursion(sign * (speed * area - half_way(plan)), sign * speed * height)
    rate = 2.0 * np.pi * motion.cycles / (timing.period * time)
    angle = rate * time * ((np.arange(timing.experiment) - timing.fade) % timing.period)[:, None]
    moved, moving = speed / rate * np.sin(angle), speed * np.cos(angle)
    return Excursion(height * moved, height * moving + slope * moved)


def half_way(plan: ExperimentPlan) -> FloatArray:
    """Return how far the slow motion alone takes the motors from a position, either way [rad or m], shape (M,).

    Args:
        plan: The plan.
    """
    timing, motion = plan.timing, plan.specification.slow_motion
    if isinstance(motion, SlowSine):
        rate = 2.0 * np.pi * motion.cycles / (timing.period * plan.sample_time)
        return motion.speeds(plan.n_motors) / rate
    if isinstance(motion, ConstantSpeed):
        return half_travel(plan.specification, plan.n_motors, timing.experiment - timing.fade, plan.sample_time)
    return np.zeros(plan.n_motors)


def _add_approaches(plan: ExperimentPlan, visit: Visit, result: Excursion) -> None:
    """Write the approach to the start of the first experiment, and from the end of the last one back."""
    half, lead = half_way(plan), plan.timing.lead
    law = approach_law(plan.specification, half)
    time = np.arange(lead, dtype=np.float64) * plan.sample_time
    share, back = law.evaluate(time, 1), law.mirrored().evaluate(time, 1)
    end = half if visit.n_experiments % 2 else -half
    result.position[:lead], result.speed[:lead] = -share[0][:, None] * half, -share[1][:, None] * half
    result.position[-lead:], result.speed[-lead:] = back[0][:, None] * end, back[1][:, None] * end
