"""Linear plants over the spring range, sampled with delay."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm

from flexros.control.context import LoopContext
from flexros.control.design.closed_loop import largest_eigenvalues
from flexros.control.design.plants import linear_plants, sampled_plants
from flexros.control.linear_controller import linear_controller
from flexros.control.pid import Pid
from flexros.robot import load_robot
from flexros.robot.linear.linearise import linear_model


def test_a_linear_robot_is_one_plant_that_equals_its_linear_model() -> None:
    robot = load_robot("four_mass_linear")
    plants = linear_plants(robot)
    A, B, C, _ = linear_model(robot).matrices()
    assert len(plants) == 1
    np.testing.assert_allclose(plants.A[0], A, atol=1e-9)
    np.testing.assert_allclose(plants.B[0], B, atol=1e-9)
    np.testing.assert_allclose(plants.C[0], C[:1], atol=1e-12)
    np.testing.assert_allclose(plants.F[0][:1], C[1:2], atol=1e-12)


def test_every_segment_of_the_spring_is_a_plant() -> None:
    robot = load_robot("four_mass")
    plants = linear_plants(robot, names=["body_1.rz.stiffness"], values=np.array([[1.0], [2.0]]))
    assert len(plants) == 10
    stiff = linear_plants(load_robot("four_mass_linear"))
    np.testing.assert_allclose(plants.A[4], stiff.A[0], atol=1e-9)
    motor = 7  # acceleration of the motor from its own angle: minus stiffness over inertia
    np.testing.assert_allclose(plants.A[:5, motor, 3], -np.array([16.7, 37.525, 58.35, 79.175, 100.0]) / 5e-3)
    np.testing.assert_allclose(plants.A[5:, motor, 3], 2 * plants.A[:5, motor, 3])


@pytest.mark.parametrize("delay", [0.0, 2e-4, 5e-4, 1.7e-3])
def test_sampling_with_delay_equals_the_continuous_solution(delay: float) -> None:
    robot = load_robot("two_mass")
    plants = linear_plants(robot)
    T = 5e-4
    sampled = sampled_plants(plants, T, delay)
    commands = np.random.default_rng(1).normal(size=(30, 1))
    x, states = np.zeros(sampled.A.shape[-1]), []
    for command in commands:
        states.append(x)
        x = sampled.A[0] @ x + sampled.B[0] @ command
    n = plants.A.shape[-1]
    fine, y = 1e-5, np.zeros(n)
    whole = np.zeros((n + 1, n + 1))
    whole[:n, :n], whole[:n, n:] = plants.A[0], plants.B[0]
    step = expm(whole * fine)
    for k in range(29 * 50):
        active = int(np.floor((k * fine - delay) / T + 1e-9))
        y = step[:n, :n] @ y + step[:n, n] * (commands[active, 0] if active >= 0 else 0.0)
    np.testing.assert_allclose(states[29][:n], y, rtol=1e-8, atol=1e-12)


def test_largest_eigenvalue_tells_the_stability_limit_of_a_known_loop() -> None:
    robot = load_robot("two_mass")
    T = robot.sample_time
    plants = sampled_plants(linear_plants(robot), T, robot.delay)
    quiet = linear_controller(Pid(kp=1e-9), LoopContext(robot, T))
    open_loop = np.max(np.abs(np.linalg.eigvals(plants.A[0])))
    assert largest_eigenvalues(plants, quiet)[0] == pytest.approx(open_loop, abs=1e-6)
    strong = linear_controller(Pid(kp=1e9), LoopContext(robot, T))
    assert largest_eigenvalues(plants, strong)[0] > 2.0
