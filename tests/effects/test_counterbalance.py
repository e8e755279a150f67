"""A counterbalance carries weight by the position of its joint."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from flexros.effects.counterbalance import Counterbalance
from flexros.robot import Robot, load_robot
from flexros.simulate.plant_model import PlantModel
from tests.effects.effect_runs import laws_of
from tests.gap.servo_logs import servo_arm

ELBOW = load_robot("elbow")


@pytest.mark.parametrize("angle", [-1.2, 0.0, 0.7])
@pytest.mark.parametrize(("cosine", "sine"), [(-60.0, 25.0), (0.0, 25.0)])
def test_torque_at_the_motor_follows_its_position(cosine: float, sine: float, angle: float) -> None:
    balanced = PlantModel(ELBOW, laws_of(ELBOW, f"counterbalance@motor_2:cosine={cosine},sine={sine}"))
    state, motor = ELBOW.equilibrium([0.0, angle]), ELBOW.motor_rows[1]
    arguments = (np.zeros(2), np.zeros(6), ca.DM(0, 1))
    difference = balanced.derivative(state, *arguments) - ELBOW.model.derivative(state, *arguments)
    rates = difference.full().ravel()[ELBOW.n_coordinates :]
    expected = np.zeros(ELBOW.n_coordinates)
    torque = cosine * np.cos(state[motor]) + sine * np.sin(state[motor])
    expected[motor] = torque / ELBOW.parameters["motor_2.inertia"].value
    np.testing.assert_allclose(rates, expected, atol=1e-9 * abs(torque))


def test_joints_that_turn_under_gravity_have_one() -> None:
    assert Counterbalance().locations(ELBOW) == ("motor_1", "motor_2")
    assert Counterbalance().locations(load_robot("two_mass")) == ()
    assert Counterbalance().locations(load_robot("emps")) == ()


@pytest.mark.parametrize(
    ("robot", "sought"),
    [
        (servo_arm().commanded_by("position"), ["motor_1", "motor_2"]),
        (servo_arm(upright=True).commanded_by("position"), []),  # motor_2 alone carries weight: another does the same
        (servo_arm(), []),  # torques show it
    ],
)
def test_it_is_sought_where_several_servos_carry_weight(robot: Robot, sought: list[str]) -> None:
    one = Counterbalance()
    assert [motor for motor in robot.joint_names if one.sought(robot, motor)] == sought
