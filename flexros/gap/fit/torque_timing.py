"""When a measured torque acted: at its stamp, in the sample before it, or in the one after it.

A recorder that notes position and torque once per sample says nothing of that. A simulator or a digital drive holds a
torque over its sample, so that the one noted with a position acted before it or acts after it, half a sample from its
stamp on average. That is a property of the recorder and no delay of the robot.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects import RobotWithEffects
from flexros.gap.candidates.tolerance import tolerance_of
from flexros.gap.fit.torque_regression import regress_torque

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.gap.candidates.tolerance import Tolerance
    from flexros.record.record import Record
    from flexros.robot import Robot

CLEAR = 0.3
"""Gain of the logarithm of what is left of all torques, by half a sample, from which it is clear [1] (chosen): 0.05 on
a UR10e whose torques are noted at their stamps, above 1 on simulated arms whose torques are held."""


def with_torque_in_time(record: Record, robot: Robot) -> Record:
    """Return a record whose measured torques are taken when they acted, as far as the rigid model shows it.

    Args:
        record: The log.
        robot: The nominal robot.
    """
    if (
        not (record.measured_torque and record.imported)
        or record.effort is None
        or not np.isfinite(record.effort).all()
    ):
        return record
    tolerance = tolerance_of(robot, {})
    usual, load = min((_left(record, robot, tolerance, load), load) for load in (False, True))
    half = {shift: _left(shifted(record, shift), robot, tolerance, load) for shift in (-0.5, 0.5)}
    best = min(half, key=half.__getitem__)
    if not usual - half[best] > CLEAR or _left(shifted(record, 2 * best), robot, tolerance, load) < half[best]:
        return record
    words = "until the next one" if best > 0 else "since the one before"
    text = f"the measured torques fit the motion where each is held {words}, half a sample from its stamp"
    return replace(shifted(record, best), warnings=(*record.warnings, text))


def shifted(record: Record, shift: float) -> Record:
    """Return a record whose measured torques act later than they are noted.

    Args:
        record: The log.
        shift: -1, -0.5, 0, 0.5 or 1: samples from the stamp of a torque to the middle of the time in which it acts.
    """
    effort = record.effort
    if effort is None or record.torque_shift == shift:
        return record
    before, after = (_later(effort, int(turn(shift - 0.5))) for turn in (np.floor, np.ceil))
    torque = (before + after) / 2
    return replace(record, torque=torque, torque_shift=shift)


def _later(values: FloatArray, samples: int) -> FloatArray:
    """Shift rows, the first or last one repeated."""
    return values[np.clip(np.arange(len(values)) - samples, 0, len(values) - 1)]


def _left(record: Record, robot: Robot, tolerance: Tolerance, load: bool) -> float:
    """Return the sum of the logarithms of what the rigid model leaves of the torques; infinite where it has none."""
    fit = regress_torque(record, RobotWithEffects(robot, ()), tolerance, load=load)
    return np.inf if fit is None else float(np.log(np.maximum(fit.rest, 1e-300)).sum())
