"""Inverse dynamics of a measured motion."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.record.balance.inverse_dynamics import SlowMotion, rigid_inverse_dynamics
from flexros.robot import load_robot


@pytest.mark.parametrize("highest", [2.0, 20.0])
def test_a_smoothed_motion_serves_for_other_zeros_of_the_encoders(highest: float) -> None:
    robot, T = load_robot("elbow"), 2e-3
    time = T * np.arange(3000)
    position = np.column_stack([0.4 * np.sin(3 * time), 0.6 * np.cos(2 * time)])
    offset = np.array([np.pi / 2, -0.3])
    found = SlowMotion.of(position, T, highest).torque(robot, offset)
    expected = rigid_inverse_dynamics(robot, position + offset, T, highest)
    np.testing.assert_allclose(found, expected, atol=1e-6 * np.abs(expected).max())
    assert np.abs(found - rigid_inverse_dynamics(robot, position, T, highest)).max() > 100
