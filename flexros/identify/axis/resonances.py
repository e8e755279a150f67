"""Antiresonances and resonances of one motor, from a frequency response or from a linear robot model."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import eigh
from scipy.signal import find_peaks

from flexros.robot.linear.linearise import linear_model

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray
    from flexros.identify.frf.frequency_response import FrequencyResponse
    from flexros.robot import Robot

PROMINENCE = 1.5
"""Factor by which a minimum or a peak must exceed the neighbouring response (chosen)."""


@dataclass(frozen=True)
class Resonances:
    """Pairs of an antiresonance and a resonance of a motor.

    Attributes:
        antiresonances: [Hz], ascending.
        resonances: [Hz], ascending, each above its antiresonance.
        source: Origin of the frequencies, as text.
    """

    antiresonances: tuple[float, ...]
    resonances: tuple[float, ...]
    source: str


def resonances_of_response(response: FrequencyResponse, joint: str, count: int) -> Resonances | None:
    """Find the most distinct pairs of a minimum and the peak above it in a response, with the other motors held still.

    With the others held, the response of motor m to its own torque is 1 / (G^-1)_mm.

    Args:
        response: Measured response of one position.
        joint: Name of the motor.
        count: Number of pairs, one less than masses.

    Returns:
        The frequencies; None where the response has fewer pairs.
    """
    motor = response.output_names.index(joint)
    whole = response.as_quantity("acceleration").response
    driving_point = 1 / np.linalg.inv(whole)[:, motor, motor]
    size, frequency = np.log(np.abs(driving_point)), np.log(response.frequency)
    lows, peaks = (find_peaks(sign * size, prominence=np.log(PROMINENCE))[0] for sign in (-1, 1))
    pairs = []
    for index, low in enumerate(lows):
        next_low = lows[index + 1] if index + 1 < len(lows) else len(size)
        above = peaks[(peaks > low) & (peaks < next_low)]
        if len(above):
            pairs.append((int(low), int(above[np.argmax(size[above])])))
    if len(pairs) < count:
        return None
    most_distinct = sorted(pairs, key=lambda pair: size[pair[0]] - size[pair[1]])[:count]
    low, high = np.exp([_vertices(np.sort(side), frequency, size) for side in np.array(most_distinct).T])
    return Resonances(tuple(low.tolist()), tuple(high.tolist()), "frequency response of the log")


def _vertices(lines: IntArray, frequency: FloatArray, size: FloatArray) -> list[float]:
    """Refine minima or peaks between the lines by parabolas through each and its neighbours."""
    refined = []
    for line in lines:
        near = slice(line - 1, line + 2)
        curvature, slope, _ = np.polyfit(frequency[near] - frequency[line], size[near], 2)
        refined.append(float(frequency[line] - slope / (2 * curvature)))
    return refined


def resonances_of_robot(robot: Robot, joint: str, count: int) -> Resonances | None:
    """Compute the frequencies of a motor of a robot at home without damping, with the other motors held still.

    Minima and peaks alternate; the pairs that are farthest apart are those of the springs with the largest motion.

    Args:
        robot: The robot.
        joint: Name of the motor.
        count: Number of pairs, one less than masses.

    Returns:
        The frequencies; None where the robot has fewer pairs.
    """
    linear = linear_model(robot)
    motor = robot.motor_rows[robot.joint_names.index(joint)]
    others = set(robot.motor_rows) - {motor}
    free = [row for row in range(len(linear.mass)) if row not in others]
    held = [row for row in free if row != motor]
    peaks = _frequencies(linear.mass, linear.stiffness, free)[1:]  # without the rigid motion of the whole axis
    lows = _frequencies(linear.mass, linear.stiffness, held)
    if len(lows) < count:
        return None
    farthest = np.sort(np.argsort(-np.asarray(peaks) / np.asarray(lows), kind="stable")[:count])
    return Resonances(
        tuple(lows[pair] for pair in farthest),
        tuple(peaks[pair] for pair in farthest),
        f"linear model of {robot.name}",
    )


def _frequencies(mass: FloatArray, stiffness: FloatArray, rows: list[int]) -> list[float]:
    """Undamped frequencies of a part of the coordinates [Hz], ascending."""
    if not rows:
        return []
    part = np.ix_(rows, rows)
    symmetric = 0.5 * (stiffness[part] + stiffness[part].T)
    squares = eigh(symmetric, mass[part], eigvals_only=True)
    return [float(value) for value in np.sqrt(np.maximum(squares, 0.0)) / (2 * np.pi)]
