"""Antiresonances and resonances of one motor: read off a frequency response, or of a robot's linear model."""

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
"""Factor by which a low or a peak must stand out of the response beside it (chosen)."""


@dataclass(frozen=True)
class Extremes:
    """Frequencies at which a motor moves least and most.

    Attributes:
        antiresonances: [Hz], ascending.
        resonances: [Hz], ascending, each above its antiresonance.
        source: Where they come from, in words.
    """

    antiresonances: tuple[float, ...]
    resonances: tuple[float, ...]
    source: str


def extremes_of_response(response: FrequencyResponse, joint: str, count: int) -> Extremes | None:
    """Read the clearest pairs of a low and the peak above it off a response, the other motors being held still.

    With the others held, the response of motor m to its own torque is 1 / (G^-1)_mm.

    Args:
        response: Measured response of one position.
        joint: Name of the motor.
        count: Number of pairs, one less than masses.

    Returns:
        The extremes; None where the response shows fewer pairs.
    """
    motor = response.output_names.index(joint)
    whole = response.as_quantity("acceleration").response
    own = 1 / np.linalg.inv(whole)[:, motor, motor]
    size, frequency = np.log(np.abs(own)), np.log(response.frequency)
    lows, peaks = (find_peaks(sign * size, prominence=np.log(PROMINENCE))[0] for sign in (-1, 1))
    pairs = []
    for place, low in enumerate(lows):
        until = lows[place + 1] if place + 1 < len(lows) else len(size)
        above = peaks[(peaks > low) & (peaks < until)]
        if len(above):
            pairs.append((int(low), int(above[np.argmax(size[above])])))
    if len(pairs) < count:
        return None
    clearest = sorted(pairs, key=lambda pair: size[pair[0]] - size[pair[1]])[:count]
    found = np.exp([_vertices(np.sort(side), frequency, size) for side in np.array(clearest).T])
    return Extremes(tuple(found[0].tolist()), tuple(found[1].tolist()), "frequency response of the log")


def _vertices(places: IntArray, frequency: FloatArray, size: FloatArray) -> list[float]:
    """Refine extremes between the lines: vertices of parabolas through each and its neighbours."""
    refined = []
    for place in places:
        near = slice(place - 1, place + 2)
        curvature, slope, _ = np.polyfit(frequency[near] - frequency[place], size[near], 2)
        refined.append(float(frequency[place] - slope / (2 * curvature)))
    return refined


def extremes_of_robot(robot: Robot, joint: str, count: int) -> Extremes | None:
    """Compute the extremes of a motor of a robot at home without damping, the other motors being held still.

    Lows and peaks alternate; the pairs that lie farthest apart are those of the springs the axis moves most against.

    Args:
        robot: The robot.
        joint: Name of the motor.
        count: Number of pairs, one less than masses.

    Returns:
        The extremes; None where the robot has fewer pairs.
    """
    linear = linear_model(robot)
    own = robot.motor_rows[robot.joint_names.index(joint)]
    others = set(robot.motor_rows) - {own}
    free = [place for place in range(len(linear.mass)) if place not in others]
    held = [place for place in free if place != own]
    peaks = _frequencies(linear.mass, linear.stiffness, free)[1:]  # the first is the motion of the axis as a whole
    lows = _frequencies(linear.mass, linear.stiffness, held)
    if len(lows) < count:
        return None
    farthest = np.sort(np.argsort(-np.asarray(peaks) / np.asarray(lows), kind="stable")[:count])
    return Extremes(
        tuple(lows[place] for place in farthest),
        tuple(peaks[place] for place in farthest),
        f"linear model of {robot.name}",
    )


def _frequencies(mass: FloatArray, stiffness: FloatArray, places: list[int]) -> list[float]:
    """Undamped frequencies of a part of the coordinates [Hz], ascending."""
    if not places:
        return []
    part = np.ix_(places, places)
    symmetric = 0.5 * (stiffness[part] + stiffness[part].T)
    squares = eigh(symmetric, mass[part], eigvals_only=True)
    return [float(value) for value in np.sqrt(np.maximum(squares, 0.0)) / (2 * np.pi)]
