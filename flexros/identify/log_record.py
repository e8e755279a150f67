"""A log for identification: the record of a diagnosis, whose checks tolerate a nominal robot with wrong parameters."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.identify.rigid.torque_timing import with_torque_in_time
from flexros.record.checks.run import check_record
from flexros.record.read import read_record

if TYPE_CHECKING:
    from flexros.logs.time_series import Log
    from flexros.record.read import TorqueSource
    from flexros.record.record import Record
    from flexros.robot import Robot


def log_record(log: Log, robot: Robot, *, name: str, torque: TorqueSource = "command") -> Record:
    """Read and check a log from which parameters of the robot are identified.

    Args:
        log: The log.
        robot: The robot with its nominal parameters.
        name: Name of the log, for messages.
        torque: Torque that is taken where both were recorded; the other one is taken where it alone was.

    Returns:
        The record of `read_record`, measured torques when they acted. Samples that a check found unusable are not
        valid.

    Raises:
        InputError: There is no usable position or torque, or a check rejects the log.
    """
    record = with_torque_in_time(read_record(log, robot, name=name, torque=torque), robot)
    return check_record(record, robot, parameters_known=False)
