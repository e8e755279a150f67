"""Default feedback controller of a robot: PID per motor up to the lowest mode, stable at home."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import eigh

from flexros.control.context import LoopContext
from flexros.control.pid import Pid
from flexros.errors import InputError
from flexros.identify.design.decay import slowest_decay
from flexros.robot.linear.linearise import linear_model

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.robot import Robot
    from flexros.robot.linear.linearise import LinearModel

BANDWIDTH = 1.0
"""Bandwidth over the lowest frequency at which the arm swings with its motors held (chosen)."""
RIGID_BANDWIDTH = 5.0
"""Bandwidth of a robot without elasticity [Hz] (chosen)."""
DAMPING = 1.0
"""Damping ratio of the rigid loop (chosen)."""
INTEGRAL = 0.15
"""Corner of the integral part over the bandwidth (chosen)."""
_SLOWEST = 0.02
"""Slowest decay that counts as stable, over the bandwidth in rad/s (chosen)."""
_HALVINGS = 8
"""How often the bandwidth is halved before giving up (chosen)."""


@lru_cache(maxsize=8)
def default_controller(robot: Robot, sample_time: float) -> Pid:
    """Choose PID gains at the home pose: rigid inertia of each axis, bandwidth at the lowest mode.

    Args:
        robot: The robot.
        sample_time: Time between two samples [s].

    Returns:
        The controller; its linear loop decays at the home pose.

    Raises:
        InputError: No bandwidth makes the loop stable.
    """
    linear = linear_model(robot, robot.home)
    inertia = _rigid_inertia(robot, linear)
    bandwidth = 2 * np.pi * _bandwidth(robot, linear)
    for _ in range(_HALVINGS):
        kp = inertia * bandwidth**2
        law = Pid(
            kp=tuple(_digits(kp)),
            ki=tuple(_digits(INTEGRAL * bandwidth * kp)),
            kd=tuple(_digits(2 * DAMPING * bandwidth * inertia)),
            derivative_filter=2 * sample_time,
        )
        if slowest_decay(linear, law, LoopContext(robot, sample_time), robot.delay) > _SLOWEST * bandwidth:
            return law
        bandwidth /= 2
    raise InputError(
        f"no PID controller holds robot {robot.name} at its home pose with a sample time of "
        f"{sample_time:g} s; give a scenario with a controller"
    )


def _rigid_inertia(robot: Robot, linear: LinearModel) -> FloatArray:
    """Inertia seen by each motor with the others at rest and all springs rigid, shape (M,)."""
    shape = np.zeros((robot.n_coordinates, robot.n_motors))
    for motor, (gear, own) in enumerate(zip(robot.gear_rows, robot.motor_rows, strict=True)):
        shape[[gear, own], motor] = 1.0
    inertia: FloatArray = np.diag(shape.T @ linear.mass @ shape).copy()
    return inertia


def _bandwidth(robot: Robot, linear: LinearModel) -> float:
    """Bandwidth in Hz: that of the lowest mode with the motors held."""
    free = [row for row in range(robot.n_coordinates) if row not in robot.motor_rows]
    if not free:
        return RIGID_BANDWIDTH
    squares = eigh(linear.stiffness[np.ix_(free, free)], linear.mass[np.ix_(free, free)], eigvals_only=True)
    return float(BANDWIDTH * np.sqrt(max(squares[0], 0.0)) / (2 * np.pi)) or RIGID_BANDWIDTH


def _digits(values: FloatArray) -> list[float]:
    """Round gains to three digits, as a person would write them."""
    return [float(f"{value:.3g}") for value in values]
