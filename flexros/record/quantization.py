"""Whether a signal lies on a lattice of equal steps: encoder quantization needs no dynamics to be seen.

The step comes from first and second differences of the signal: the smallest are one step, or a few, and all others are
multiples of it. A signal with noise of its own in every sample has no such step.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.record.record import Record
    from flexros.robot import Robot

QUANTILES = (0.0, 0.002, 0.02)
"""Quantiles of the differences that may be one step, or a few (the largest of them measured by prototype: 8 of 8 found,
none in 88 false; the smaller ones find steps below the noise of a fast motion)."""

FEWEST = 50
"""Fewest differences that tell anything (chosen)."""

OFF_LATTICE = 0.08
"""Largest rms distance of the differences from multiples of a step, in steps; 0.29 where there is none (chosen)."""

MATTERS = 0.05
"""Rms error of rounding over the noise of the encoder from which a lattice is an effect (chosen)."""

_DIVISORS = range(1, 7)  # the quantile may be so many steps
_MULTIPLES = (8.0, 64.0, 512.0)  # differences up to so many steps refine it, one after the other


@dataclass(frozen=True)
class Quantization:
    """Quantization of an encoder.

    Attributes:
        motor: Number of the motor (0-based).
        step: Step in the coordinate of the robot file [rad or m].
    """

    motor: int
    step: float


def lattice_step(values: FloatArray) -> float | None:
    """Find the step of a lattice.

    Args:
        values: Signal, shape (n,).

    Returns:
        The step in the unit of the signal; None where there is no lattice.
    """
    signal = values[np.isfinite(values)]
    if len(signal) < FEWEST or len(np.unique(signal)) < 3:
        return None
    resolution = 32 * float(np.spacing(np.abs(signal).max()))
    change = np.abs(np.concatenate([np.diff(signal), np.diff(signal, 2)]))
    change = change[change > resolution]
    if len(change) < FEWEST:
        return None
    for first in np.unique(np.quantile(change, QUANTILES)):
        for divisor in _DIVISORS:
            step = _refined(float(first) / divisor, change)
            if step > 4 * resolution and _distance(change, step, resolution) < OFF_LATTICE:
                return step
    return None


def _refined(step: float, change: FloatArray) -> float:
    """Fit the step to ever longer differences."""
    for most in _MULTIPLES:
        near = change[change < (most + 0.5) * step]
        count = np.rint(near / step)
        if not np.any(count):
            return step
        step = float(near @ count / (count @ count))
    return step


def _distance(change: FloatArray, step: float, resolution: float) -> float:
    """Return the rms distance of differences from multiples of a step, in steps, of those that are not too long."""
    short = change[change < (_MULTIPLES[-1] + 0.5) * step]
    if len(short) < FEWEST:
        return float("inf")
    off = short / step - np.rint(short / step)
    beyond = float(np.mean(np.rint(short / step) == 0))
    return float(np.sqrt(np.mean(off**2))) + beyond + resolution / step


def encoder_quantization(record: Record, robot: Robot) -> tuple[Quantization, ...]:
    """Find the encoders whose rounding matters beside their noise.

    Args:
        record: The record; positions that were interpolated have no lattice any more.
        robot: The robot, for the noise of its encoders.

    Returns:
        Quantizations by motor, none where there is none.
    """
    found = []
    for motor in range(robot.n_motors):
        step = lattice_step(record.position[record.valid, motor])
        if step is None or step / np.sqrt(12) < MATTERS * float(robot.encoder_noise[motor]):
            continue
        found.append(Quantization(motor, step))
    return tuple(found)
