"""Rows of the regression of torques."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.effects import RobotWithEffects
from flexros.gap.residuals.torque_rows import acting_torque, torque_rows
from flexros.record.record import Record
from flexros.robot import load_robot


@pytest.mark.parametrize(("samples", "enough"), [(330, True), (200, True), (100, False)])
def test_a_short_log_of_a_slow_recorder_has_rows_of_a_wider_band(samples: int, enough: bool) -> None:
    """At 25 Hz the usual band of 2.5 Hz needs 400 samples."""
    robot = load_robot("emps")
    position = 0.1 * np.sin(0.5 * np.arange(samples) * 0.04)[:, None]
    record = Record("log", 0.04, position, np.ones_like(position), np.ones(samples, dtype=bool), imported=True)
    rows = torque_rows(record, robot, acting_torque(record, RobotWithEffects(robot, ()), 0.0))
    assert (rows is not None) == enough
