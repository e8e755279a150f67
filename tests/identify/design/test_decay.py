"""Decay of loops: one position as many, robots with stiff gears too."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm

from flexros.control.base import control_law
from flexros.control.context import LoopContext
from flexros.identify.design.decay import decays_at, slowest_decay
from flexros.robot import load_robot
from flexros.robot.linear.linearise import linear_model


@pytest.mark.parametrize("name", ["e12", "emps", "four_mass_linear"])
def test_decays_at_positions_are_those_of_their_linear_models(name: str) -> None:
    robot = load_robot(name)
    law = control_law({"kind": "pid", "kp": 2e3, "kd": 200.0})
    motors = robot.equilibrium()[list(robot.motor_rows)][None]
    expected = slowest_decay(linear_model(robot), law, LoopContext(robot, robot.sample_time), robot.delay)
    assert decays_at(robot, motors, law, robot.sample_time) == pytest.approx([expected], rel=1e-6)


def test_progress_counts_positions() -> None:
    robot, told = load_robot("e12"), []
    motors = np.tile([0.0, 0.3], (200, 1))
    decays_at(robot, motors, control_law({"kind": "pid", "kp": 2e3, "kd": 200.0}), 5e-4, told.append)
    assert told == [128, 200]


@pytest.mark.parametrize("fraction", [0.0, 0.4])
def test_whole_samples_of_delay_are_past_measurements(fraction: float) -> None:
    """A controller that answers two samples late is one whose command acts two samples late."""
    robot, T = load_robot("two_mass"), 1e-3
    linear = linear_model(robot)
    law = control_law({"kind": "pid", "kp": 3e4, "kd": 500.0})
    A, B, C, _ = linear.matrices()
    n, late, prompt = len(A), *(_held(A, B, time) for time in (fraction * T, (1 - fraction) * T))
    # states: plant, error before, command of the last sample and of those before
    loop = np.zeros((n + 4, n + 4))
    command = np.zeros(n + 4)
    command[:n], command[n] = -(3e4 + 500.0 / T) * C[0], -500.0 / T
    loop[:n, :n] = prompt[0] @ late[0]
    loop[:n, n + 3 :] = prompt[0] @ late[1]
    loop[:n, n + 2 : n + 3] += prompt[1]
    loop[n, :n], loop[n + 1], loop[n + 2, n + 1], loop[n + 3, n + 2] = -C[0], command, 1.0, 1.0
    expected = -np.log(np.max(np.abs(np.linalg.eigvals(loop)))) / T
    assert slowest_decay(linear, law, LoopContext(robot, T), (2 + fraction) * T) == pytest.approx(expected, rel=1e-8)


def _held(A: np.ndarray, B: np.ndarray, time: float) -> tuple[np.ndarray, np.ndarray]:
    whole = np.zeros((len(A) + 1, len(A) + 1))
    whole[:-1, :-1], whole[:-1, -1:] = A, B
    whole = expm(whole * time)
    return whole[:-1, :-1], whole[:-1, -1:]
