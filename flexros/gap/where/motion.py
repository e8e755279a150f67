"""Motion of the motors in a log: speeds, accelerations, rotor angles and transmitted torques of the gears."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.signal import savgol_filter

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.record.record import Record
    from flexros.robot import Robot

WINDOW = 0.02
"""Window over which measured positions are smoothed for speeds and accelerations [s] (chosen)."""


@dataclass(frozen=True, eq=False)
class MotorMotion:
    """Motion of the motors of a log.

    Attributes:
        position: Motor positions [rad or m], shape (n, M).
        speed: Their rates [rad/s or m/s], shape (n, M).
        acceleration: Rates of these [rad/s2 or m/s2], smoothed, shape (n, M).
        rotor_angle: Angles of the rotors [rad], shape (n, M): the motor position times the gear ratio where values are
            stated on the arm side.
        torque: Torque commands [Nm or N], shape (n, M).
        torsion: Motor minus arm coordinate of each gear [rad or m], shape (n, M); NaN for rigid gears and where the
            states of the model are not known.
        gear_torque: Torque that spring and damper of each gear transmit to the arm by the model [Nm or N], shape
            (n, M); NaN as before.
    """

    position: FloatArray
    speed: FloatArray
    acceleration: FloatArray
    rotor_angle: FloatArray
    torque: FloatArray
    torsion: FloatArray
    gear_torque: FloatArray


def motion_of(record: Record, robot: Robot, states: FloatArray | None = None) -> MotorMotion:
    """Compute the motion of the motors.

    Args:
        record: The log.
        robot: The nominal robot, N arm coordinates and M motors.
        states: Filtered states of its model, coordinates, then their rates, then any others, shape (n, n_x); None:
            speeds are taken from smoothed measured positions.

    Returns:
        The motion.
    """
    rows, nq = list(robot.motor_rows), robot.n_coordinates
    if states is None:
        speed = _smoothed(record.position, record.sample_time, 1)
    else:
        speed = np.ascontiguousarray(states[:, nq:][:, rows])
    torsion, gear_torque = _gears(robot, states, record.position.shape)
    return MotorMotion(
        position=record.position,
        speed=speed,
        acceleration=_smoothed(speed, record.sample_time, 1),
        rotor_angle=record.position * robot.rotor_turns,
        torque=record.torque,
        torsion=torsion,
        gear_torque=gear_torque,
    )


def _smoothed(values: FloatArray, sample_time: float, order: int) -> FloatArray:
    """Differentiate a quadratic fitted to a sliding window."""
    length = max(5, 2 * round(WINDOW / sample_time / 2) + 1)
    if len(values) < length:
        return np.gradient(values, sample_time, axis=0)
    return np.asarray(savgol_filter(values, length, 2, deriv=order, delta=sample_time, axis=0))


def _gears(robot: Robot, states: FloatArray | None, shape: tuple[int, ...]) -> tuple[FloatArray, FloatArray]:
    """Return torsions and transmitted torques of the gears."""
    torsion, torque = np.full(shape, np.nan), np.full(shape, np.nan)
    flexible = list(robot.flexible_motors)
    if states is None or not flexible:
        return torsion, torque
    n, nq = robot.n_arm, robot.n_coordinates
    q, v = states[:, :nq], states[:, nq : 2 * nq]
    arms = [robot.gear_rows[number] for number in flexible]
    torsion[:, flexible] = q[:, n:] - q[:, arms]
    force = robot.model.transmission_force
    values = robot.model.parameter_values
    # one pass over all samples; the parameters are no symbols here
    mapped = force.map(len(q))(q[:, :n].T, v[:, :n].T, q[:, n:].T, v[:, n:].T, np.tile(values[:, None], (1, len(q))))
    torque[:, flexible] = np.asarray(mapped, dtype=float).T[:, arms]
    return torsion, torque
