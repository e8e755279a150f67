"""Torques of a log as a regression sees them: as they act, at low-passed positions, few in number."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.identify.rigid.motion_estimate import lowest_cutoff
from flexros.identify.rigid.record import torque_as_it_acts
from flexros.identify.rigid.regression_rows import RegressionRows
from flexros.identify.rigid.regressor import RigidRegressor
from flexros.record.missing_samples import bridged_motion
from flexros.record.smoothing import motion_cutoff
from flexros.record.torques.servo_torque import servo_parts

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.effects import RobotWithEffects
    from flexros.record.record import Record
    from flexros.robot import Robot

FEWEST = 8
"""Fewest samples after decimation that a regression is made of (chosen)."""


@dataclass(frozen=True, eq=False)
class ActingTorque:
    """Torques as they act: their mean over one sample around each position.

    Attributes:
        torque: The torques [Nm or N], shape (n, M).
        begin: First sample around which commands acted throughout.
        springs: The part of the stiffness of servos [Nm or N], shape (n, M); zeros without them.
    """

    torque: FloatArray
    begin: int
    springs: FloatArray


def acting_torque(record: Record, model: RobotWithEffects, delay: float) -> ActingTorque:
    """Average torques over one sample around each position; those of servos follow from their commands.

    Args:
        record: The log.
        model: The nominal model.
        delay: Delay of the commands beyond that of the model [s].
    """
    robot = model.robot
    delay += model.added_delay if record.measured_torque else robot.delay
    if record.command is None:
        torque, begin = torque_as_it_acts(record, delay)
        return ActingTorque(torque, begin, np.zeros_like(torque))
    command, begin = torque_as_it_acts(replace(record, torque=record.command), delay)
    parts = servo_parts(robot, command, bridged_motion(record.position, record.valid), record.sample_time)
    return ActingTorque(parts.torque, begin, parts.spring)


def torque_rows(record: Record, robot: Robot, acting: ActingTorque) -> RegressionRows | None:
    """Filter and decimate a log; the corner of the low-pass is higher in one that is short for its rate.

    Args:
        record: The log.
        robot: The nominal robot.
        acting: Its torques as they act.

    Returns:
        The rows; None where no motor moves, where too few are left, and for links that bend.
    """
    begin = acting.begin
    try:
        regressor = RigidRegressor(robot)
        part, every = record.part(begin, record.n_samples), tuple(range(len(regressor.parameters)))
        cutoff = max(motion_cutoff(record.sample_time), lowest_cutoff(part.n_samples, record.sample_time))
        rows = RegressionRows.of_record(part, acting.torque[begin:], cutoff, regressor, every)
    except InputError:
        return None
    return rows if len(rows.torque) >= FEWEST and rows.motion.moving.any() else None
