"""Logs with one effect each."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.arrays import FloatArray
from flexros.robot import load_robot
from tests.oracles.linear_gap import LinearLog, linear_log


def swing(n: int, sample_time: float, amplitudes: tuple[float, ...], hertz: tuple[float, ...]) -> FloatArray:
    """Let each motor swing at a frequency of its own, growing from rest."""
    time = sample_time * np.arange(n)[:, None]
    grown = np.minimum(time, 1.0)
    return np.asarray(grown * np.array(amplitudes) * np.sin(2 * np.pi * np.array(hertz) * time))


@pytest.fixture(scope="session")
def elbow_without_gap() -> LinearLog:
    robot = load_robot("elbow")
    return linear_log(robot, swing(12000, robot.sample_time, (0.2, 0.2), (0.5, 0.8)), (1e5, 6e3), seed=2)


@pytest.fixture(scope="session")
def elbow_with_friction() -> LinearLog:
    """Dry friction at motor_2."""
    robot = load_robot("elbow")

    def friction(time: float, position: FloatArray, speed: FloatArray, command: FloatArray) -> FloatArray:
        del time, position, command
        return np.array([0.0, -20.0]) * np.tanh(speed / 1e-3)

    return linear_log(robot, swing(12000, robot.sample_time, (0.2, 0.2), (0.5, 0.8)), (1e5, 6e3), friction)


@pytest.fixture(scope="session")
def axis_with_ripple() -> LinearLog:
    """Cogging of order 6 at the motor of the four masses."""
    robot = load_robot("four_mass_linear")

    def ripple(time: float, position: FloatArray, speed: FloatArray, command: FloatArray) -> FloatArray:
        del time, speed, command
        return np.asarray(0.05 * np.sin(6 * position + 0.3))

    return linear_log(robot, swing(16000, robot.sample_time, (12.0,), (0.3,)), (10.0, 0.8), ripple)
