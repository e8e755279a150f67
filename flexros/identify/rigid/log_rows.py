"""The regression of one log: its record, its torques at the positions, filtered."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.identify.log_record import log_record
from flexros.identify.rigid.record import torque_as_it_acts, torque_at_samples
from flexros.identify.rigid.regression_rows import RegressionRows

if TYPE_CHECKING:
    from flexros.identify.rigid.base_parameters import BaseParameters
    from flexros.identify.rigid.regressor import RigidRegressor
    from flexros.identify.rigid.settings import RigidSettings
    from flexros.logs.time_series import Log


def rows_of_log(
    log: Log, settings: RigidSettings, label: str, regressor: RigidRegressor, base: BaseParameters
) -> RegressionRows:
    """Read and filter a log.

    Args:
        log: The log.
        settings: Cut-off, source of the torque, and how commands are paired with positions.
        label: Name of the log, for messages.
        regressor: The regressor.
        base: The base parameters.

    Raises:
        InputError: The log does not fit the robot, is too short, or has no motion or no torque.
    """
    robot = regressor.robot
    record = log_record(log, robot, name=label, torque=settings.torque)
    torque = torque_at_samples(record)
    if settings.hold and not record.measured_torque:
        acting, begin = torque_as_it_acts(record, robot.delay)
        record, torque = record.part(begin, record.n_samples), acting[begin:]
    rows = RegressionRows.of_record(record, torque, settings.cutoff_at(1 / record.sample_time), regressor, base.leading)
    if not np.any(rows.motion.moving):
        raise InputError(
            f"{label}: no motion: the position of {', '.join(robot.joint_names)} does not change beyond its noise; "
            "give a log in which the motors move"
        )
    return rows
