"""Robots as MJCF: the motion that MuJoCo computes is ours, in joint units whatever side the robot file states."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from flexros.effects.patching.export import export_model
from flexros.effects.patching.patched_robot import load_patched
from flexros.robot import Robot

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")


def joint_positions(robot: Robot, q: np.ndarray) -> np.ndarray:
    """Positions of the joints of the file: motor, then deflection of its gear, in joint units."""
    positions = []
    for row, joint in enumerate(robot.joints):
        if joint.motor_coordinate is None:
            positions.append(q[row])
        else:
            motor = q[robot.n_arm + joint.motor_coordinate]
            positions += [motor, q[row] - motor]
    ratio = robot.motors[0].gear_ratio if robot.spec.coordinates == "motor" else 1.0
    return np.array(positions) / ratio


@pytest.mark.parametrize("name", ["two_mass", "four_mass_linear", "elbow", "six_axis", "emps"])
def test_motion_is_that_of_the_robot(name: str) -> None:
    patched = load_patched(name)
    robot, duration, steps = patched.base, 0.1, 400
    start = robot.equilibrium(robot.home)
    size = 0.3 if robot.spec.coordinates == "motor" else 200.0
    torque = robot.holding_torque(start) + size * np.cos(np.arange(robot.n_motors))

    def rate(_t: float, x: np.ndarray) -> np.ndarray:
        return np.asarray(robot.model.derivative(x, torque, np.zeros(6), [])).ravel()

    n = robot.n_coordinates
    ours = solve_ivp(rate, (0, duration), start, method="DOP853", rtol=1e-10, atol=1e-12).y[:n, -1]
    model = mujoco.MjModel.from_xml_string(export_model(patched, "mjcf").text)
    model.opt.timestep = duration / steps
    model.actuator_ctrllimited[:] = 0
    getattr(model, "actuator_delay", np.zeros(1))[:] = 0
    data = mujoco.MjData(model)
    data.qpos[:], data.ctrl[:] = joint_positions(robot, start[:n]), torque
    before = data.qpos.copy()
    for _ in range(steps):
        mujoco.mj_step(model, data)
    moved = np.abs(data.qpos - before).max()
    np.testing.assert_allclose(data.qpos, joint_positions(robot, ours), atol=1e-6 * moved)


def test_gravity_of_a_slanted_base_is_written(tmp_path: Path) -> None:
    patch = tmp_path / "patch.yaml"
    patch.write_text("robot: elbow\neffects:\n  - {effect: base_tilt, location: base, parameters: {x: 0.1}}\n")
    exported = export_model(load_patched(patch), "mjcf")
    gravity = [0, -9.81 * np.sin(0.1), -9.81 * np.cos(0.1)]
    np.testing.assert_allclose(mujoco.MjModel.from_xml_string(exported.text).opt.gravity, gravity, atol=1e-9)
    assert [row.value for row in exported.written if row.location == "base"] == pytest.approx(gravity)


def test_motor_side_friction_comes_times_the_gear_ratio(tmp_path: Path) -> None:
    """A torque just below the level on the motor side holds the joint, one just above it moves it."""
    patch = tmp_path / "patch.yaml"
    patch.write_text(
        "robot: four_mass_linear\neffects:\n"
        "  - {effect: coulomb_friction, location: motor_1, parameters: {level: 0.5}}\n"
        "  - {effect: viscous_friction, location: motor_1, parameters: {coefficient: 0.002}}\n"
        "  - {effect: torque_gain_error, location: motor_1, parameters: {relative: 0.25}}\n"
    )
    exported = export_model(load_patched(patch), "mjcf")
    model = mujoco.MjModel.from_xml_string(exported.text)
    assert model.dof_frictionloss[0] == pytest.approx(0.5 * 220)
    assert model.dof_damping[0] == pytest.approx(0.008 * 220**2)
    assert model.dof_armature[0] == pytest.approx(5e-3 * 220**2)
    assert model.actuator_gear[0, 0] == pytest.approx(1.25 * 220)
    if hasattr(model, "actuator_delay"):
        assert model.actuator_delay[0] == 5e-4
    speeds = []
    for torque in (0.98 * 0.4, 1.1 * 0.4):  # 0.4 times the gain of 1.25 is the level
        data = mujoco.MjData(model)
        for _ in range(2000):
            data.ctrl[:] = torque
            mujoco.mj_step(model, data)
        speeds.append(220 * data.qvel[0])
    assert abs(speeds[0]) < 0.02 * speeds[1]


def test_planar_bodies_get_a_tensor_that_a_body_can_have() -> None:
    model = mujoco.MjModel.from_xml_string(export_model(load_patched("elbow"), "mjcf").text)
    assert model.body_inertia[1] == pytest.approx([4, 4, 4])


def test_nonlinear_gear_is_listed() -> None:
    exported = export_model(load_patched("four_mass"), "mjcf")
    assert [(each.location, each.name) for each in exported.not_held] == [("body_1.rz", "nonlinear spring")]
