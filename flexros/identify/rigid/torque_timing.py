"""When a noted torque acted: at its stamp, in the sample before it, or in the one after it.

A recorder that notes position and torque once per sample says nothing of that. A simulator or a digital drive holds a
torque over its sample, so that the one noted with a position acted before it or acts after it, half a sample from its
stamp on average. That is a property of the recorder and no delay of the robot.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.identify.rigid.base_parameters import base_parameters
from flexros.identify.rigid.regression_rows import RegressionRows
from flexros.identify.rigid.regressor import RigidRegressor
from flexros.record.smoothing import motion_cutoff
from flexros.record.torques.shifted_torque import HELD, moved_later, shifted, timing_is_open

if TYPE_CHECKING:
    from flexros.record.record import Record
    from flexros.robot import Robot

CLEAR = 0.3
"""Gain of the logarithm of what is left of all torques, by half a sample, from which it is clear [1] (chosen)."""

SHIFTS = (-1.0, -0.5, 0.0, 0.5, 1.0)
"""Samples from the stamp of a torque to the middle of the time in which it acts."""

FEWEST = 3
"""Fewest rows over the base parameters [1] (chosen)."""


def with_torque_in_time(record: Record, robot: Robot) -> Record:
    """Return a record whose noted torques are taken when they acted, as far as a rigid robot shows it.

    Commands that act later than held ones do so by a delay of the robot, so that they stay.

    Args:
        record: The log.
        robot: The nominal robot; only its geometry matters, its base parameters and friction are free.
    """
    left = torques_left(record, robot) if timing_is_open(record) else {}
    if not left:
        return record
    usual = record.torque_shift
    best = min((-0.5, 0.5) if record.measured_torque else (-0.5, 0.0), key=left.__getitem__)
    beyond = best + (0.5 if best > usual else -0.5)
    if not left[usual] - left[best] > CLEAR or left[beyond] < left[best]:
        return record
    return in_time(record, best)


def in_time(record: Record, shift: float) -> Record:
    """Return a record whose noted torques act elsewhere in their sample, and that says so.

    Args:
        record: The log.
        shift: 0.5 where a torque is held from its stamp on, -0.5 where it was held before, 0 where it acts at it.
    """
    kind = "measured torques" if record.measured_torque else "commands"
    where = {
        HELD: "where each is held until the next one, half a sample from its stamp",
        -HELD: "where each was held since the one before, half a sample from its stamp",
    }
    thinned = "as values at their stamps, half a sample before they act if held: as where a recorder keeps some of them"
    text = f"the {kind} fit the motion {where.get(shift, thinned)}"
    return replace(shifted(record, shift), warnings=(*record.warnings, text))


def torques_left(record: Record, robot: Robot) -> dict[float, float]:
    """Return what no rigid robot explains of the torques, by their shift: the sum of the logarithms over the motors.

    Each motor has base parameters of its own, which are fitted by least squares (Moberg 2007, eq. 4.11 to 4.13).

    Args:
        record: The log, with noted torques.
        robot: The nominal robot.

    Returns:
        Sum of natural logarithms of rms torques for each of `SHIFTS`; empty where the log has no such regression: too
        short, no motion, torques missing, or links that bend.
    """
    assert record.noted is not None
    noted = np.where(record.predicted, record.noted, 0.0)
    late = 0.0 if record.measured_torque else robot.delay / record.sample_time
    try:
        regressor = RigidRegressor(robot)
        base = base_parameters(regressor, robot.n_motors)
        rows = RegressionRows.of_record(record, noted, motion_cutoff(record.sample_time), regressor, base.leading)
    except InputError:
        return {}
    if not rows.motion.moving.any() or len(rows.torque) < FEWEST * len(base.leading):
        return {}
    H = np.concatenate([block for block, _ in rows.blocks()])
    torque = np.stack([rows.decimated(moved_later(noted, shift + late)) for shift in SHIFTS], axis=2)
    rest = np.zeros(len(SHIFTS))
    for motor in np.flatnonzero(record.predicted).tolist():
        own = H[:, motor, :][:, np.any(H[:, motor] != 0, axis=0)]
        size = np.maximum(np.linalg.norm(own, axis=0), 1e-300)
        error = torque[:, motor] - own @ (np.linalg.lstsq(own / size, torque[:, motor], rcond=None)[0] / size[:, None])
        rest += np.log(np.maximum(np.sqrt(np.mean(error**2, axis=0)), 1e-300))
    return dict(zip(SHIFTS, rest.tolist(), strict=True))
