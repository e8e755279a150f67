"""Speed of the moves between positions, estimated before the experiment is checked."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.config.per_motor import per_motor

if TYPE_CHECKING:
    from collections.abc import Iterator

    from flexros.arrays import FloatArray
    from flexros.identify.experiment.specification import MoveSettings
    from flexros.robot import Robot

FACTORS = (1.0, 0.7, 0.5, 0.35, 0.25, 0.18, 0.12)
"""Factors of the acceleration that are tried (chosen)."""
_RESERVE = 0.93
"""Share of the allowed torque that the rigid prediction may reach; the rest is for what it neglects (chosen)."""
_POINTS = 9
"""Points along a move at which torques are computed (chosen)."""
_PHASES = ((0.0, 1.0), (0.0, -1.0), (1.0, 0.0), (0.75, 0.75), (0.75, -0.75))
"""Shares of the largest speed and acceleration that meet (chosen)."""


def move_factor(
    robot: Robot, start: FloatArray, positions: FloatArray, move: MoveSettings, allowed: FloatArray
) -> float:
    """Find by what factor the acceleration of moves must be lowered for the torques of the rigid robot.

    The speed is scaled with the root of the factor, which keeps the shape of the moves.

    Args:
        robot: The robot with its nominal values.
        start: Gear coordinates at the start [rad or m], shape (M,).
        positions: Gear coordinates in the order of the experiment [rad or m], shape (S, M).
        move: Largest speed and acceleration that are wanted.
        allowed: Largest torque [Nm or N], shape (M,).

    Returns:
        The largest of `FACTORS` that suffices; the smallest where none does.
    """
    states = list(_states(robot, start, positions, move))
    for factor in FACTORS:
        torques = np.array([_torque(robot, q, np.sqrt(factor) * v, factor * a) for q, v, a in states])
        if torques.size == 0 or np.all(np.abs(torques) <= _RESERVE * allowed):
            return factor
    return FACTORS[-1]


def _states(
    robot: Robot, start: FloatArray, positions: FloatArray, move: MoveSettings
) -> Iterator[tuple[FloatArray, FloatArray, FloatArray]]:
    """Yield gear coordinates, speeds and accelerations that moves along straight lines pass."""
    fastest = per_motor("identification.move.speed", move.speed, robot.n_motors)
    strongest = per_motor("identification.move.acceleration", move.acceleration, robot.n_motors)
    for begin, end in zip(np.vstack([start, positions[:-1]]), positions, strict=True):
        way = end - begin
        size = np.abs(way)
        if not np.any(size > 0):
            continue
        speed = way * float(np.min(fastest[size > 0] / size[size > 0]))
        acceleration = way * float(np.min(strongest[size > 0] / size[size > 0]))
        for share in np.linspace(0.0, 1.0, _POINTS):
            for of_speed, of_acceleration in _PHASES:
                yield begin + share * way, of_speed * speed, of_acceleration * acceleration


def _torque(robot: Robot, gears: FloatArray, speed: FloatArray, acceleration: FloatArray) -> FloatArray:
    """Torque of the motors of the rigid robot, shape (M,)."""
    arm, model = robot.arm_from_gears, robot.model
    values = model.parameter_values
    need = model.arm_inverse_dynamics(arm(gears), arm(speed), arm(acceleration), values).full().ravel()
    parameters, rows = robot.parameters, list(robot.gear_rows)
    motors = [f"motor_{number + 1}" for number in range(robot.n_motors)]
    inertia = np.array([parameters[f"{motor}.inertia"].value for motor in motors])
    friction = np.array([parameters[f"{motor}.viscous_friction"].value for motor in motors])
    torque: FloatArray = need[rows] + inertia * acceleration + friction * speed
    return torque
