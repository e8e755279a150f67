"""Joints whose motion is prescribed: it is measured, but the torque that made it is not.

A torque that was not recorded, or that has nothing to do with the motion, would let the prediction of its joint run
away, and all other joints with it. The measured motion drives the model there: a motor of practically infinite inertia
J has the torque J q'' of the measured acceleration q'', so that it moves as it did whatever acts on it, and the other
joints feel it. Nothing is said about such a joint.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError, unknown_name
from flexros.record.missing_samples import bridged_motion
from flexros.record.smoothing import motion_cutoff, smooth_motion
from flexros.robot.exchange.joint_names import tagged

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from flexros.record.record import Record
    from flexros.robot import Robot

INERTIA = 1e9
"""Inertia of a motor whose motion is prescribed [kg m2 or kg] (chosen): torques of a robot of any size accelerate it by
less than any encoder resolves."""


def motors_named(robot: Robot, names: Collection[str]) -> tuple[int, ...]:
    """Return the indices of motors.

    Args:
        robot: The robot.
        names: Names of motors, or of their joints where the robot file names them.

    Raises:
        InputError: A motor does not exist.
    """
    known = {tagged(robot, name): index for index, name in enumerate(robot.joint_names)}
    known |= {name: index for index, name in enumerate(robot.joint_names)}
    for name in names:
        if name not in known:
            raise unknown_name("motor", name, [one for one in known if one], "prescribed")
    return tuple(sorted({known[name] for name in names}))


def with_prescribed_motion(record: Record, robot: Robot, motors: Sequence[int], reason: str) -> Record:
    """Return a record in which the measured motion of some motors drives the model.

    Args:
        record: The log, with torques.
        robot: The nominal robot.
        motors: Indices of the motors.
        reason: Why, as the end of a sentence for the warnings.

    Raises:
        InputError: No motor is left whose torque counts.
    """
    further = [motor for motor in motors if motor not in record.prescribed]
    if not further:
        return record
    prescribed = tuple(sorted({*record.prescribed, *further}))
    names = ", ".join(robot.joint_names[motor] for motor in further)
    if len(prescribed) == robot.n_motors:
        raise InputError(
            f"{record.name}: the motion of every motor would be prescribed ({reason}), so nothing is left to predict; "
            "a diagnosis needs the torque of one motor at least",
            "prescribed",
        )
    text = (
        f"the measured motion of {names} drives the model there, since {reason}: the other joints feel it, and nothing "
        f"is said about {names}"
    )
    position = bridged_motion(record.position, record.valid)
    acceleration = smooth_motion(position, record.sample_time, motion_cutoff(record.sample_time))[2]
    delay = 0.0 if record.measured_torque else robot.delay / record.sample_time
    samples, torque = np.arange(record.n_samples), record.torque.copy()
    for motor in further:  # the mean from a sample to the next, ahead by what the model delays it
        torque[:, motor] = INERTIA * np.interp(samples + 0.5 + delay, samples, acceleration[:, motor])
    noted = record.noted
    if noted is not None:
        noted = noted.copy()
        noted[:, further] = np.nan
    return replace(record, torque=torque, noted=noted, prescribed=prescribed, warnings=(*record.warnings, text))


def without_prescribed(record: Record) -> Record:
    """Return a record whose prescribed motors have no torque, for checks of the torques that were recorded."""
    if not record.prescribed:
        return record
    torque = record.torque.copy()
    torque[:, list(record.prescribed)] = 0.0
    return replace(record, torque=torque)
