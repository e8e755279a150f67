"""Motions and logs that the tests of this room share."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from flexros.feedforward.rigid_arm import RigidArm
from flexros.logs.stamps import stamps_ns
from flexros.logs.time_series import JointSeries, Log
from flexros.robot import Robot, load_robot


def fourier_motion(n: int, sample_time: float, motors: int, seed: int = 1, amplitude: float = 0.5) -> np.ndarray:
    """Periodic motion of a few slow harmonics with its derivatives, shape (3, n, M)."""
    rng = np.random.default_rng(seed)
    time = np.arange(n)[:, None] * sample_time
    motion = np.zeros((3, n, motors))
    for harmonic in range(1, 6):
        w = 2 * np.pi * 0.2 * harmonic
        size, phase = amplitude * rng.uniform(0.3, 1, motors) / harmonic**0.5, rng.uniform(0, 2 * np.pi, motors)
        motion += [
            size * np.sin(w * time + phase),
            size * w * np.cos(w * time + phase),
            -size * w**2 * np.sin(w * time + phase),
        ]
    return motion


def rigid_log(
    robot: Robot,
    motion: np.ndarray,
    sample_time: float = 1e-3,
    noise: float = 0.0,
    friction: Callable[[np.ndarray], np.ndarray] | None = None,
    seed: int = 2,
) -> Log:
    """Log of a rigid robot that moves exactly: torque of the inverse dynamics, an oracle of its own, and friction."""
    rng = np.random.default_rng(seed)
    result = RigidArm(robot).inverse_dynamics(motion)
    torque = result.torque + (friction(motion[1]) if friction else 0.0)
    stamp = stamps_ns(motion.shape[1], sample_time)
    position = result.motor_position + noise * rng.normal(size=result.motor_position.shape)
    return Log(
        joint_states=JointSeries(stamp, robot.joint_names, position=position),
        joint_commands=JointSeries(stamp, robot.joint_names, effort=torque),
    )


@pytest.fixture(name="fourier_motion")
def fourier_motion_fixture():
    return fourier_motion


@pytest.fixture(name="rigid_log")
def rigid_log_fixture():
    return rigid_log


@pytest.fixture
def unchecked(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave out the checks of a log: of six axes they take far longer than the fit, and have tests of their own."""
    monkeypatch.setattr("flexros.identify.log_record.check_record", lambda record, robot, parameters_known: record)


@pytest.fixture(scope="session")
def elbow() -> Robot:
    return load_robot("elbow")


@pytest.fixture(scope="session")
def emps() -> Robot:
    return load_robot("emps")
