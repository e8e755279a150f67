"""The rotor that a robot file leaves out."""

from __future__ import annotations

import pytest

from flexros.effects.left_out.rotor_inertia import RotorInertia
from tests.gap.servo_logs import servo_robot


@pytest.mark.parametrize(
    ("commands", "inertia", "sought"), [("position", 0.0, True), ("position", 0.05, False), ("torque", 0.0, True)]
)
def test_it_is_a_candidate_where_the_motor_has_none(commands: str, inertia: float, sought: bool) -> None:
    robot = servo_robot().with_values({"motor_1.inertia": inertia})
    robot = robot.commanded_by("position") if commands == "position" else robot
    assert RotorInertia().sought_if_measured(robot, "motor_1") == sought
    assert not RotorInertia().sought(robot, "motor_1")
