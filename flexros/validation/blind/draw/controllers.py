"""Controllers that differ from case to case, and the feedforward that goes with them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from flexros.control.cascade import Cascade
from flexros.control.pid import Pid
from flexros.identify.design.default_controller import default_controller

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.control.base import AbstractControlLaw
    from flexros.robot import Robot

SOFTEST, STIFFEST = 0.6, 1.15
"""Bandwidth over that of the robot's usual controller (chosen)."""
CASCADES = 0.4
"""Share of cascades among the controllers (chosen)."""


def random_controller(robot: Robot, sample_time: float, random: np.random.Generator) -> AbstractControlLaw:
    """Draw a controller: PID, or a speed loop under a position loop.

    Args:
        robot: The robot as it is known.
        sample_time: Time between two samples [s].
        random: Random numbers.

    Returns:
        The control law.
    """
    usual = default_controller(robot, sample_time)
    factor = random.uniform(SOFTEST, STIFFEST)
    kp = factor**2 * np.atleast_1d(usual.kp)
    kd = factor * np.atleast_1d(usual.kd)
    ki = factor**3 * np.atleast_1d(usual.ki) * random.choice([0.0, 0.5, 1.0])
    if random.uniform() < CASCADES:
        return Cascade(
            position_gain=tuple(0.5 * kp / kd),
            speed_gain=tuple(kd),
            integral_gain=tuple(0.25 * kp),
            speed_filter=2 * sample_time,
        )
    return Pid(kp=tuple(kp), ki=tuple(ki), kd=tuple(kd), derivative_filter=float(random.choice([1, 2])) * sample_time)


def feedforward(robot: Robot, position: FloatArray, sample_time: float, full: bool) -> FloatArray:
    """Compute the feedforward torque of a reference.

    Args:
        robot: The robot as it is known, taken for rigid.
        position: Motor positions [rad], shape (n, M).
        sample_time: Time between two samples [s].
        full: With the torque that accelerates; else only what holds the start.

    Returns:
        Torque [Nm or N], shape (n, M).
    """
    if not full:
        rest = robot.equilibrium(robot.home, motor_position=position[0])
        return np.repeat(robot.holding_torque(rest)[None], len(position), axis=0)
    speed = np.gradient(position, sample_time, axis=0)
    acceleration = np.gradient(speed, sample_time, axis=0)
    q, v, a = (ca.SX.sym(name, robot.n_motors) for name in "qva")
    arm = [robot.arm_from_gears(value) for value in (q, v, a)]
    need = robot.model.arm_inverse_dynamics(*arm, robot.model.parameter_values)[list(robot.gear_rows)]
    motors = [motor.specification for motor in robot.motors]
    inertia, friction = ([getattr(m, key).value for m in motors] for key in ("inertia", "viscous_friction"))
    torque = need + ca.DM(inertia) * a + ca.DM(friction) * v
    function = ca.Function("feedforward", [q, v, a], [ca.densify(torque)])
    return np.asarray(function(position.T, speed.T, acceleration.T)).T
