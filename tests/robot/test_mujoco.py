"""Robots in motion against MuJoCo, an independent implementation."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from flexros.robot import load_robot

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")


@pytest.mark.parametrize("name", ["e12", "elbow", "six_axis"])
def test_motion_agrees_with_mujoco(name: str) -> None:
    from tests.oracles.mujoco_model import mujoco_model

    robot = load_robot(name)
    n, step, duration = robot.n_coordinates, 2.5e-4, 0.2
    start = robot.equilibrium(robot.home)
    torque = robot.holding_torque(start) + 200.0 * np.cos(np.arange(robot.n_motors))

    def rate(_t: float, x: np.ndarray) -> np.ndarray:
        return np.asarray(robot.model.derivative(x, torque, np.zeros(6), [])).ravel()

    ours = solve_ivp(rate, (0, duration), start, method="DOP853", rtol=1e-10, atol=1e-12).y[:n, -1]
    model = mujoco_model(robot, step)
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:], data.ctrl[:] = start[:n], start[n:], torque
    for _ in range(round(duration / step)):
        mujoco.mj_step(model, data)
    moved = np.abs(ours - start[:n])
    assert moved.max() > 1e-3
    np.testing.assert_allclose(data.qpos, ours, atol=1e-6 * moved.max())
