"""Lead of servos that follow the rate of their command."""

from __future__ import annotations

import numpy as np

from flexros.simulate.plant import Plant
from flexros.simulate.servo_lead import servo_leads
from tests.gap.servo_logs import T, servo_robot


def test_lead_is_the_share_of_the_damping_over_the_stiffness() -> None:
    robot = servo_robot(0.5)
    np.testing.assert_allclose(servo_leads(robot, {}), [0.5 * 2.0 / 60.0])
    np.testing.assert_allclose(servo_leads(robot, {"motor_1.servo_stiffness": 30.0}), [0.5 * 2.0 / 30.0])


def test_plant_follows_the_rate_of_the_command_by_its_damping() -> None:
    """A joint in the plane that turns with its command, without viscous friction, lags behind by no angle."""
    still = {"gravity.z": 0.0, "motor_1.viscous_friction": 0.0}
    for feedforward, lag in ((0.0, 2.0 * 0.5 / 60.0), (1.0, 0.0)):
        robot = servo_robot(feedforward).with_values(still).commanded_by("position")
        plant = Plant(robot, T, np.zeros(2), substeps=8)
        for k in range(1000):
            behind = k * T * 0.5 - plant.measure()[0]
            plant.advance([k * T * 0.5])
        # the command is held through a sample, on average half a sample behind
        assert abs(behind - lag - 0.5 * T * 0.5) < 1e-4


def test_integral_of_a_servo_sees_the_command_without_its_lead() -> None:
    """A joint that follows a ramp without error has nothing to integrate."""
    still = {"gravity.z": 0.0, "motor_1.viscous_friction": 0.0, "motor_1.servo_integral": 200.0}
    robot = servo_robot(1.0).with_values(still).commanded_by("position")
    plant = Plant(robot, T, np.zeros(4), substeps=8)
    for k in range(1000):
        behind = k * T * 0.5 - plant.measure()[0]
        plant.advance([k * T * 0.5])
    assert abs(behind - 0.5 * T * 0.5) < 3e-4
