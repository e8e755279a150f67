"""Gravity errors are the torques of the weight that the model does not know, and no inertia."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from flexros.arrays import FloatArray
from flexros.effects.gravity_error import GravityError
from flexros.robot import Robot, load_robot
from flexros.simulate.plant_model import PlantModel
from tests.effects.effect_runs import halving_errors, laws_of

pytestmark = pytest.mark.slow

ELBOW, SIX_AXIS = load_robot("elbow"), load_robot("six_axis")


def added_force(robot: Robot, text: str, arm: FloatArray, speed: FloatArray) -> FloatArray:
    """Read the added force off the accelerations of the arm."""
    n, nq = robot.n_arm, robot.n_coordinates
    x = np.zeros(2 * nq)
    x[:n], x[nq : nq + n] = arm, speed
    arguments = (np.zeros(robot.n_motors), np.zeros(6), ca.DM(0, 1))
    model = PlantModel(robot, laws_of(robot, text))
    difference = (model.derivative(x, *arguments) - robot.model.derivative(x, *arguments)).full().ravel()
    force: FloatArray = robot.model.arm_inertia(arm, np.zeros(0)).full() @ difference[nq : nq + n]
    return force


def gravity_force(robot: Robot, arm: FloatArray) -> FloatArray:
    """Force of gravity on the arm coordinates."""
    still = np.zeros(robot.n_arm)
    force: FloatArray = -robot.model.arm_inverse_dynamics(arm, still, still, np.zeros(0)).full().ravel()
    return force


@pytest.mark.parametrize(("robot", "body"), [(ELBOW, 1), (ELBOW, 2), (SIX_AXIS, 3), (SIX_AXIS, 7)])
def test_relative_error_scales_the_weight_alone(robot: Robot, body: int) -> None:
    random = np.random.default_rng(body)
    name = f"body_{body}.mass"
    heavier = robot.with_values({name: 1.2 * robot.parameters[name].value})
    arm = robot.home + random.normal(0.0, 0.4, robot.n_arm)
    speed = random.normal(size=robot.n_arm)
    expected = gravity_force(heavier, arm) - gravity_force(robot, arm)
    force = added_force(robot, f"gravity_error@body_{body}:relative=0.2", arm, speed)
    np.testing.assert_allclose(force, expected, atol=1e-7 * np.max(np.abs(expected)))


def test_moment_shifts_the_centre_of_mass_along_the_body() -> None:
    mass = ELBOW.parameters["body_1.mass"].value
    center = ELBOW.parameters["body_1.center_of_mass.z"].value  # the upper arm is along z
    shifted = ELBOW.with_values({"body_1.center_of_mass.z": center + 3.0 / mass})
    arm = np.array([0.7, -0.4])
    force = added_force(ELBOW, "gravity_error@body_1:moment=3", arm, np.zeros(2))
    np.testing.assert_allclose(force, gravity_force(shifted, arm) - gravity_force(ELBOW, arm), atol=1e-9)
    assert force[0] == pytest.approx(3.0 * 9.81 * np.sin(0.7))


def test_robot_at_rest_deflects_more_and_requires_more_torque() -> None:
    state = ELBOW.equilibrium(ELBOW.home)
    model = PlantModel(ELBOW, laws_of(ELBOW, "gravity_error@body_2:relative=0.3"))
    rest = model.rest(state)
    rate = model.derivative(model.start(rest.state), rest.torque, np.zeros(6), ca.DM(0, 1))
    assert np.max(np.abs(rate.full())) < 1e-7
    more = -0.3 * 45.0 * 9.81 * 0.35 * np.cos(rest.state[0] + rest.state[1])
    assert rest.torque[1] == pytest.approx(1.3 / 0.3 * more, rel=1e-9)


def test_halving_the_step_converges() -> None:
    state = ELBOW.equilibrium(ELBOW.home)
    hold = ELBOW.holding_torque(state)
    law = laws_of(ELBOW, "gravity_error@body_2:relative=0.3,moment=1")
    errors = halving_errors(ELBOW, law, 200, lambda time: hold, state)
    assert errors[0] < 1e-6
    assert errors[1] < errors[0] / 12


def test_neutral_values_switch_it_off_and_weightless_robots_have_none() -> None:
    assert PlantModel(ELBOW, laws_of(ELBOW, "gravity_error@body_2:relative=0,moment=0")).laws == ()
    assert len(PlantModel(ELBOW, laws_of(ELBOW, "gravity_error@body_2:moment=1")).laws) == 1
    assert GravityError().locations(load_robot("e12")) == ()
    assert GravityError().locations(ELBOW) == ("body_1", "body_2")
