"""Joints of a real machine whose recorded torque has nothing to do with their motion: it is prescribed."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.record.balance.joint_assignments import WEIGHTLESS
from flexros.record.balance.regression import coefficients
from flexros.record.checks.checked_record import FOREIGN, SLOW, CheckedRecord
from flexros.record.checks.other_robot import LEAST
from flexros.record.prescribed_motion import with_prescribed_motion, without_prescribed
from flexros.record.smoothing import smooth_motion

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.record.record import Record
    from flexros.robot import Robot

SMALL = 1 / 3
"""Torque of a motor over that of the rigid arm, both rms, below which it may not be the torque of that motion [1]
(chosen): masses and torque constants of a robot file are not wrong by this factor. Friction adds to a torque: 0.8 and
more on measured robots, 0.05 to 0.2 in the wrist of one without torque sensors there."""


def without_foreign_torque(record: Record, robot: Robot) -> Record:
    """Return a record in which no torque counts that is none of its motion.

    Such a torque is far smaller than what the bodies need and, unlike one whose weight is balanced or whose unit is
    wrong, no multiple of that, no harmonic of the position and no friction: a drive without a current sensor, or a
    current that is not that of the motor. Nor does a link swing freely there, whose acceleration is that of its weight.
    Predictions would run away there, and the prediction of all other joints with them. A log without any other torque
    stays as it is.

    Args:
        record: The log.
        robot: The nominal robot.
    """
    if not record.imported or record.command is not None:
        return record
    checked = CheckedRecord(without_prescribed(record), robot)
    if checked.balance is None or checked.order_is_wrong:
        return record
    unlike = np.array([fit is not None and fit.as_is < LEAST for fit in checked.own])
    if not unlike.any():
        return record
    small = unlike & (checked.over_all[1] < SMALL)
    if not small.any():
        return record
    foreign = small & (_unexplained(checked) > FOREIGN)
    foreign = foreign & (_weight_left(checked) > FOREIGN) if foreign.any() else foreign
    motors = np.flatnonzero(foreign).tolist()
    if not motors or len({*motors, *record.prescribed}) == robot.n_motors:
        return record
    reason = (
        f"the recorded torque has nothing to do with the motion: it is less than a third of what the bodies of robot "
        f"{robot.name} need, and neither a part of that nor friction or balance"
    )
    return with_prescribed_motion(record, robot, motors, reason)


def _unexplained(checked: CheckedRecord) -> FloatArray:
    """Return the share of the power of each slow torque that is no part of its motion [1], shape (M,).

    Parts are a multiple of what the bodies need, friction, a rotor, an offset, and a spring or a gas cylinder that
    carries weight: its torque is a harmonic of the position.
    """
    torque, arm, of_drive = checked.slow_parts
    position = smooth_motion(checked.position, checked.record.sample_time, SLOW)[0, checked.slow_samples]
    parts = np.concatenate([np.stack([arm, np.cos(position), np.sin(position)], axis=-1), of_drive], axis=-1)
    return _left(torque, parts, torque, nothing=0.0)


def _weight_left(checked: CheckedRecord) -> FloatArray:
    """Return the share of each weight that neither its torque nor its acceleration carries [1], shape (M,).

    Inertias and friction may be any: those of the bodies, each of another size, and of a rotor. One where there is no
    weight.
    """
    robot, samples = checked.robot, checked.slow_samples
    torque, arm, of_drive = checked.slow_parts
    without = checked.torque_without(WEIGHTLESS)[samples]
    moving = [f"body_{k}.inertia." for k, body in enumerate(robot.spec.bodies, 1) if body.directions]
    inertias = [[name for name in robot.parameters if name.startswith(body)] for body in moving]
    of_bodies = [without, *(arm - checked.torque_without(names)[samples] for names in inertias)]
    parts = np.concatenate([np.stack(of_bodies, axis=-1), of_drive], axis=-1)
    return _left(torque - (arm - without), parts, arm - without, nothing=1.0)


def _left(torque: FloatArray, parts: FloatArray, whole: FloatArray, nothing: float) -> FloatArray:
    """Return the power that parts of any size leave of torques, over that in which others change [1], shape (M,).

    Args:
        torque: The torques [Nm or N], shape (n, M).
        parts: The parts of each, shape (n, M, k).
        whole: The others [Nm or N], shape (n, M).
        nothing: The share where these do not change [1].
    """
    rest = [one - parts[:, motor] @ coefficients(parts[:, motor], one) for motor, one in enumerate(torque.T)]
    left, power = np.mean(np.square(rest), axis=1), np.var(whole, axis=0)
    shares: FloatArray = np.divide(left, power, out=np.full(len(power), nothing), where=power > 0)
    return shares
