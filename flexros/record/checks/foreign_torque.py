"""Joints of a real machine whose recorded torque has nothing to do with their motion: it is prescribed."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.record.checks.checked_record import FOREIGN, CheckedRecord
from flexros.record.checks.other_robot import LEAST
from flexros.record.prescribed_motion import with_prescribed_motion, without_prescribed

if TYPE_CHECKING:
    from flexros.record.record import Record
    from flexros.robot import Robot

SMALL = 1 / 3
"""Torque of a motor over that of the rigid arm, both rms, below which it may not be the torque of that motion [1]
(chosen): masses and torque constants of a robot file are not wrong by this factor. Friction adds to a torque: 0.8 and
more on measured robots, 0.05 to 0.2 in the wrist of one without torque sensors there."""


def without_foreign_torque(record: Record, robot: Robot) -> Record:
    """Return a record in which no torque counts that is none of its motion.

    Such a torque is far smaller than what the bodies need and, unlike one whose weight is balanced or whose unit is
    wrong, no multiple of that and no friction: a drive without a current sensor, or a current that is not that of the
    motor. Predictions would run away there, and the prediction of all other joints with them. A log without any other
    torque stays as it is.

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
    foreign = unlike & (checked.over_all[1] < SMALL) & (np.diag(checked.unexplained) > FOREIGN)
    motors = np.flatnonzero(foreign).tolist()
    if not motors or len({*motors, *record.prescribed}) == robot.n_motors:
        return record
    reason = (
        f"the recorded torque has nothing to do with the motion: it is less than a third of what the bodies of robot "
        f"{robot.name} need, and neither a part of that nor friction"
    )
    return with_prescribed_motion(record, robot, motors, reason)
