"""Integrator and time step with which MuJoCo simulates a robot stably."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.robot.exchange.link_inertia import LEAST

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.robot import Robot
    from flexros.robot.exchange.numbers import RepairedNumbers

RK4_REACH = 1.0
"""Largest absolute eigenvalue times the time step with RK4 [1] (chosen): it is stable up to 2.5 in all directions."""
STIFFNESS_REACH = 0.2
"""Largest natural frequency times the time step with implicitfast [rad] (chosen): it is stable up to 2 without damping,
and this accurate to 0.2 % of the frequency."""
MOST_HALVINGS = 10
"""Halvings of the sample time at most (chosen): more are only needed by springs between bodies without mass."""


def time_step(robot: Robot, numbers: RepairedNumbers) -> tuple[float, str]:
    """Return time step [s] and integrator for a robot: the sample time and RK4 where that is stable with a margin.

    RK4 is accurate, but damping and stiffness are explicit in it: a stiff servo or much damping at a light body makes
    it unstable. Then it is implicitfast, in which damping is implicit, with the sample time halved until natural
    frequencies are resolved.

    Args:
        robot: The robot with the changes of its effects.
        numbers: Its numbers on the joint side.
    """
    mass, damping, stiffness = _linear(robot, numbers)
    n, step = len(mass), robot.sample_time
    system = np.block(
        [
            [np.zeros((n, n)), np.eye(n)],
            [-np.linalg.solve(mass, stiffness), -np.linalg.solve(mass, damping)],
        ]
    )
    if step * np.abs(np.linalg.eigvals(system)).max() <= RK4_REACH:
        return step, "RK4"
    for _ in range(MOST_HALVINGS):
        frequency = np.sqrt(np.abs(np.linalg.eigvals(np.linalg.solve(mass + step * damping, stiffness))).max())
        if step * frequency <= STIFFNESS_REACH:
            break
        step /= 2
    return step, "implicitfast"


def _linear(robot: Robot, numbers: RepairedNumbers) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return mass, damping and stiffness matrix at the home pose with gears at rest, servos closed and links rigid."""
    motors = [robot.home[row] for row, joint in enumerate(robot.joints) if joint.motor_coordinate is not None]
    q = np.concatenate([robot.home, motors])
    blocks = robot.model.linearised()(q, np.zeros(len(q)), np.zeros(robot.n_motors))
    mass, damping, stiffness, torque, encoder = (np.asarray(block, dtype=float) for block in blocks[:5])
    squared = robot.motors[0].gear_ratio ** 2 if robot.spec.coordinates == "motor" else 1.0
    kp = [(each.servo_stiffness or 0.0) / squared for each in numbers.joints]
    kv = [
        ((each.servo_damping or 0.0) + each.damping) / squared - motor.specification.viscous_friction.value
        for each, motor in zip(numbers.joints, robot.motors)
    ]
    damping = damping + torque @ np.diag(kv) @ encoder
    stiffness = stiffness + torque @ np.diag(kp) @ encoder
    held = [row for row in range(len(q)) if row >= robot.n_arm or robot.joints[row].mode is None]
    rows = np.ix_(held, held)
    return mass[rows] + LEAST * np.eye(len(held)), damping[rows], stiffness[rows]
