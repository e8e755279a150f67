"""When a measured torque acted on robots with springs; see `flexros.identify.rigid.torque_timing` for rigid ones.

The torques themselves show it where the springs are nearly right. Where they are far off, or a gear has backlash, what
that leaves hides half a sample; then a fit of the log shows it, see `flexros.gap.fit.noted_timing`.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects import RobotWithEffects
from flexros.errors import InputError
from flexros.gap.candidates.tolerance import tolerance_of
from flexros.gap.fit.arm_torque import arm_torque
from flexros.gap.fit.torque_regression import regress_torque
from flexros.gap.residuals.fit_data import fit_data
from flexros.gap.settings import DiagnosisSettings
from flexros.identify.rigid.torque_timing import CLEAR, in_time
from flexros.record.shifted_torque import shifted, timing_is_open

if TYPE_CHECKING:
    from flexros.record.record import Record
    from flexros.robot import Robot

DELAYED = CLEAR / 2
"""Further gain by a whole sample from which it is rather a delay [1] (chosen): springs that are far off leave much."""


def with_torque_in_time_behind_springs(
    record: Record, robot: Robot, settings: DiagnosisSettings | None = None
) -> Record:
    """Return a record whose measured torques are taken when they acted, as far as the robot with its springs shows it.

    Args:
        record: The log.
        robot: The nominal robot.
        settings: Settings of the diagnosis.
    """
    settings = settings or DiagnosisSettings()
    if not record.measured_torque or len(robot.flexible_motors) < robot.n_motors or not timing_is_open(record):
        return record
    model, tolerance = RobotWithEffects(robot, ()), tolerance_of(robot, {}, record.prescribed)
    try:
        data = fit_data(record, model, settings)
    except InputError:
        return record

    def left(shift: float) -> float:
        """Sum the logarithms of what the model leaves of the torques."""
        part = shifted(data.record, shift)
        arm = arm_torque(replace(data, record=part), model, tolerance)
        found = regress_torque(part, model, tolerance, arm, settings=settings.torque_start)
        return np.inf if found is None else float(np.log(np.maximum(found.rest, 1e-300)).sum())

    usual, half = left(0.0), {shift: left(shift) for shift in (-0.5, 0.5)}
    best = min(half, key=half.__getitem__)
    if not usual - half[best] > CLEAR or half[best] - left(2 * best) > DELAYED:
        return record
    return in_time(record, best)
