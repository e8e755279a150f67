"""From a log to the record that a diagnosis takes: read, completed by what is known of its experiment, and checked."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.record.checks.run import check_record
from flexros.record.read import read_record
from flexros.scenario.recorded_experiment import with_recorded_parts

if TYPE_CHECKING:
    from flexros.logs.time_series import Log
    from flexros.record.record import Record
    from flexros.robot import Robot


def checked_log(log: Log, robot: Robot, *, name: str) -> Record:
    """Read a log and check its record for what would mislead a diagnosis: units, signs, joint order, clipping.

    Args:
        log: The log.
        robot: The nominal robot.
        name: Name of the log, for messages.

    Returns:
        The record; its warnings say what was repaired or is doubtful.

    Raises:
        InputError: There is no usable position or torque, or a check rejects the log; the sentence says why.
    """
    return check_record(with_recorded_parts(read_record(log, robot, name=name), log), robot)
