"""Readings of encoders with periodic errors as a function of motor position, and the inverse."""

from __future__ import annotations

from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from flexros.effects.kinds.sensor import AbstractSensor

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.effects import PlacedLaw
    from flexros.robot import Robot

PERIODIC = 0
"""Rank of periodic errors between motor and log, see `AbstractSensor.rank`; quantization follows."""

MAX_ITERATIONS = 200
"""Largest number of iterations to find the position of a reading; each reduces the error by the slope of the periodic
error (chosen)."""


def encoder_reading(robot: Robot, laws: Sequence[PlacedLaw], motor: int) -> ca.Function:
    """Return the function from position to reading of one motor, without noise and quantization.

    Args:
        robot: The robot.
        laws: Laws on it; those that are not periodic errors of this motor's encoder are skipped.
        motor: Index of the motor (0-based).

    Returns:
        (position, speed) -> (reading, rate of the reading) [rad or m, per s], scalars.
    """
    q, v = ca.SX.sym("q"), ca.SX.sym("v")
    turns = float(robot.rotor_turns[motor])
    read = q
    for law in laws:
        effect = law.effect
        if law.location == robot.joint_names[motor] and isinstance(effect, AbstractSensor) and effect.rank == PERIODIC:
            read = effect.read(read, turns * q, effect.parameter_values)
    return ca.Function("reading", [q, v], [read, ca.jtimes(read, q, v)])


def position_of_reading(robot: Robot, laws: Sequence[PlacedLaw], reading: FloatArray) -> FloatArray:
    """Compute the motor positions for given encoder readings, by fixed-point iteration.

    Args:
        robot: The robot.
        laws: Laws on it.
        reading: Readings of all encoders [rad or m], shape (M,).

    Returns:
        Motor positions [rad or m], shape (M,).
    """
    position = np.array(reading, dtype=float)
    for motor, wanted in enumerate(reading):
        function = encoder_reading(robot, laws, motor)
        for _ in range(MAX_ITERATIONS):
            error = float(wanted) - float(function(position[motor], 0.0)[0])
            position[motor] += error
            if abs(error) <= np.finfo(float).eps * max(1.0, abs(wanted)):
                break
    return position
