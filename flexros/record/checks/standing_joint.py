"""Joints of a real machine that stand still in a log while others move: their motion is prescribed."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.record.checks.checked_record import CheckedRecord
from flexros.record.prescribed_motion import with_prescribed_motion, without_prescribed

if TYPE_CHECKING:
    from flexros.record.record import Record
    from flexros.robot import Robot

DRIVEN = 0.3
"""Change of a torque beside that of the arm, over the largest of the joints that move and over the torque itself, all
rms, above which the encoder of a joint may be stuck whose position never changes at all [1] (chosen); a check tells
that. A torque that hardly changes holds a weight, and of several such joints at once none is stuck."""


def without_standing_joints(record: Record, robot: Robot) -> Record:
    """Return a record in which no torque of a joint counts that stands still.

    A brake, a gear that does not give way, or friction holds it, whatever its torque is: a model without that would run
    away there, and an effect would be named for it. Joints count as standing that do not move beyond noise and rounding
    of their encoder.

    Args:
        record: The log.
        robot: The nominal robot.
    """
    if not record.imported or record.command is not None or robot.n_motors == 1:
        return record
    checked = CheckedRecord(without_prescribed(record), robot)
    standing = ~checked.moves
    standing[list(record.prescribed)] = False
    if not standing.any() or not checked.moves.any():
        return record
    torque = checked.record.torque[record.valid]
    driving = (checked.record.torque - checked.rigid_torque())[record.valid].std(axis=0)
    largest = np.maximum(torque[:, checked.moves].std(axis=0).max(), np.sqrt(np.mean(torque**2, axis=0)))
    constant = np.ptp(checked.record.position[record.valid], axis=0) == 0
    stuck = constant & (driving >= DRIVEN * largest) & (constant.sum() == 1)
    motors = np.flatnonzero(standing & ~stuck).tolist()
    if not motors or len({*motors, *record.prescribed}) == robot.n_motors:
        return record
    reason = "it stands still in this log" if len(motors) == 1 else "they stand still in this log"
    return with_prescribed_motion(record, robot, motors, reason)
