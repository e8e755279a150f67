"""Outputs of further sensors, against formulas and differences of the motion."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from flexros.effects import parse_effect, place_effects
from flexros.robot import load_robot
from flexros.simulate.plant_model import PlantModel

TOOL = [(name, axis) for name in ("tool acceleration", "tool turning rate") for axis in range(3)]


def plant(robot: str, *effects: str) -> PlantModel:
    model = place_effects(load_robot(robot), [parse_effect(text, "test") for text in effects])
    return PlantModel(model.robot, model.laws)


def state_of(model: PlantModel, seed: int = 0) -> np.ndarray:
    state = 0.3 * np.random.default_rng(seed).normal(size=2 * model.model.n_coordinates)
    return model.start(state, np.zeros(model.robot.n_motors))


def outputs(model: PlantModel, wanted: list[tuple[str, int]], x: np.ndarray, u: np.ndarray | None = None) -> np.ndarray:
    torque = np.zeros(model.robot.n_motors) if u is None else u
    return np.asarray(model.sensor_outputs(wanted)(x, torque, []).full().ravel())


@pytest.mark.parametrize("robot", ["elbow", "four_mass"])
def test_a_link_is_the_arm_behind_the_gear(robot: str) -> None:
    model = plant(robot)
    x, row, n = state_of(model), model.robot.gear_rows[0], model.model.n_coordinates
    np.testing.assert_array_equal(outputs(model, [("link position", 0), ("link speed", 0)], x), [x[row], x[n + row]])


def test_the_torque_of_a_flexible_joint_is_that_of_spring_and_damper() -> None:
    model = plant("elbow")
    robot, x = model.robot, state_of(model)
    q, v = x[: robot.n_coordinates], x[robot.n_coordinates : 2 * robot.n_coordinates]
    for motor, (arm, own) in enumerate(zip(robot.gear_rows, robot.motor_rows)):
        name = robot.joints[arm].name
        k, d = (robot.parameters[f"{name}.{key}"].value for key in ("stiffness", "damping"))
        expected = k * (q[own] - q[arm]) + d * (v[own] - v[arm])
        assert outputs(model, [("joint torque", motor)], x)[0] == pytest.approx(expected)


def test_effects_in_the_gear_act_on_its_torque() -> None:
    x = state_of(plant("elbow"))
    plain, stiff = (
        outputs(plant("elbow", *more), [("joint torque", 0)], x)[0]
        for more in ((), ("nonlinear_stiffness@body_1.ry:relative=1.0,knee=0.01",))
    )
    assert abs(stiff) > 1.5 * abs(plain)


def test_the_torque_behind_a_rigid_gear_moves_the_load_alone() -> None:
    """The motor of emps carries its own inertia and friction; the rest moves the mass behind it."""
    model = plant("emps")
    robot, x, u = model.robot, state_of(model), np.array([3.0])
    acceleration = float(model.derivative(x, u, np.zeros(6), []).full()[robot.n_coordinates, 0])
    load = robot.parameters["body_1.mass"].value
    assert outputs(model, [("joint torque", 0)], x, u)[0] == pytest.approx(load * acceleration)


def test_the_imu_shows_gravity_at_rest() -> None:
    model = plant("elbow")
    rest = model.robot.equilibrium(motor_position=np.zeros(2))
    found = outputs(model, TOOL, model.start(rest))
    assert np.linalg.norm(found[:3]) == pytest.approx(9.81, abs=1e-3)
    np.testing.assert_allclose(found[3:], 0.0, atol=1e-12)


@pytest.mark.parametrize("robot", ["elbow", "e12", "six_axis"])
def test_the_imu_agrees_with_the_motion_of_the_tool(robot: str) -> None:
    model = plant(robot)
    x, u, n, h = state_of(model, 1), np.ones(model.robot.n_motors), model.model.n_coordinates, 1e-5
    q, v = x[:n], x[n : 2 * n]
    a = model.derivative(x, u, np.zeros(6), []).full().ravel()[n : 2 * n]
    before, now, after = (
        model.model.tool_pose((q + t * v + t**2 / 2 * a)[: model.model.n_arm], []).full().ravel() for t in (-h, 0, h)
    )
    turn = Rotation.from_quat(now[3:]).inv()
    gravity = np.array(model.robot.spec.gravity.value)
    moved = (after - 2 * now + before)[:3] / h**2
    found = outputs(model, TOOL, x, u)
    scale = max(1.0, float(np.abs(moved).max()))
    np.testing.assert_allclose(found[:3], turn.apply(moved - gravity), atol=2e-3 * scale)
    rate = (Rotation.from_quat(before[3:]).inv() * Rotation.from_quat(after[3:])).as_rotvec() / (2 * h)
    np.testing.assert_allclose(found[3:], rate, rtol=1e-2, atol=1e-4 * max(1.0, float(np.abs(rate).max())))


def test_slopes_are_those_of_the_outputs() -> None:
    model = plant("elbow")
    x, wanted = state_of(model), [("link position", 1), ("joint torque", 0), ("tool turning rate", 2)]
    slopes, step = model.sensor_slopes(wanted, x), 1e-6
    moved = [(outputs(model, wanted, x + step * one) - outputs(model, wanted, x)) / step for one in np.eye(len(x))]
    np.testing.assert_allclose(slopes, np.stack(moved, axis=1), rtol=1e-4, atol=1e-3)
