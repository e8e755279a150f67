"""Inverse dynamics of the rigid robot: what it commands is what the robot does."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

from flexros.config.yaml_file import read_yaml
from flexros.control.model.rigid_dynamics import gravity_torque, rigid_torque
from flexros.robot import Robot, load_robot
from flexros.robot.robot import LIBRARY, robot_from_data


def rigid(name: str) -> Robot:
    data = dict(read_yaml(LIBRARY / f"{name}.yaml"))
    for body in data["bodies"]:
        for direction in body["directions"].values():
            direction["spring"] = "rigid"
            direction.pop("damper", None)
    return robot_from_data(data, "test.yaml")


def torque(robot: Robot, *motion: np.ndarray) -> np.ndarray:
    parts = [casadi.SX.sym(name, robot.n_motors) for name in "qva"]
    return np.asarray(casadi.Function("u", parts, [rigid_torque(robot, *parts)])(*motion)).ravel()


def test_rigid_elbow_accelerates_as_commanded() -> None:
    robot, random = rigid("elbow"), np.random.default_rng(3)
    q, v, a = random.standard_normal((3, 2))
    u = torque(robot, q, v, a)
    assert robot.model.acceleration(q, v, u, np.zeros(6), []).full().ravel() == pytest.approx(a, rel=1e-9)


@pytest.mark.parametrize("name", ["elbow", "e12", "six_axis"])
def test_flexible_robot_without_deflection_needs_arm_rotor_and_friction(name: str) -> None:
    robot, random = load_robot(name), np.random.default_rng(4)
    q, v, a = 0.3 * random.standard_normal((3, robot.n_motors))
    arm = [robot.arm_from_gears(part) for part in (q, v, a)]
    load = robot.model.arm_inverse_dynamics(*arm, []).full().ravel()[list(robot.gear_rows)]
    parameters = robot.parameters
    inertia, friction = (
        np.array([parameters[f"{motor}.{key}"].value for motor in robot.joint_names])
        for key in ("inertia", "viscous_friction")
    )
    assert torque(robot, q, v, a) == pytest.approx(load + inertia * a + friction * v, rel=1e-8, abs=1e-6)


def test_gravity_torque_holds_the_arm() -> None:
    robot = load_robot("elbow")
    state = robot.equilibrium([0.4, -0.3])
    q = casadi.SX.sym("q", 2)
    held = casadi.Function("g", [q], [gravity_torque(robot, q)])(state[:2])
    assert np.asarray(held).ravel() == pytest.approx(robot.holding_torque(state), rel=1e-9)
