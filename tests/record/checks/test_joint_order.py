"""Torques that belong to other motors."""

from __future__ import annotations

import pytest


@pytest.mark.parametrize("robot", ["e12", "elbow"])
def test_swapped_torques_are_named(found, healthy, robot: str) -> None:
    findings = found(robot, torque=healthy(robot).torque[:, ::-1])
    assert findings[0].hopeless
    assert findings[0].text == (
        "joints are swapped between torques and positions: the torque called motor_1 belongs to the motion of motor_2, "
        "the torque called motor_2 belongs to the motion of motor_1; correct the names when importing"
    )
