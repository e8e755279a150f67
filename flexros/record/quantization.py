"""Quantisation step of a signal, from its differences alone.

The smallest first and second differences of a quantised signal are one step, or a few, and all others are multiples of
it. A signal with noise of its own in every sample has no such step.
"""

from __future__ import annotations

from dataclasses import dataclass
from hashlib import blake2b
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.record.record import Record
    from flexros.robot import Robot

QUANTILES = (0.0, 0.002, 0.02)
"""Quantiles of the differences that may be one step, or a few (the largest one by prototype: 8 of 8 detected, none of
88 false; the smaller ones detect steps below the noise of a fast motion)."""

FEWEST = 50
"""Fewest differences that are used (chosen)."""

OFF_LATTICE = 0.08
"""Largest rms distance of the differences from multiples of a step, in steps; 0.29 without quantisation (chosen)."""

MATTERS = 0.05
"""Rms rounding error over the noise of the encoder above which quantisation counts (chosen)."""

ROUNDED = (1e-5, 1e-4, 1e-3)
"""Differences over the largest one up to which they are rounding of the file, such as decimals of text (chosen): more
where that shows no step, as text of eight digits has one decimal less from 1 rad on."""

SOME = 4000
"""Differences of which most steps are ruled out already, before all are looked at (chosen)."""

MOST_KNOWN = 1000
"""Signals whose steps are remembered (chosen): those of many logs."""

AT_REST = 0.9
"""Share of samples equal to the one before above which a signal is at rest (chosen)."""

_DIVISORS = range(1, 7)  # number of steps that the quantile may be
_MULTIPLES = (8.0, 64.0, 512.0)  # differences up to these numbers of steps refine it in turn
_KNOWN: dict[bytes, float | None] = {}  # steps by the digests of the signals


@dataclass(frozen=True)
class Quantization:
    """Quantization of an encoder.

    Attributes:
        motor: Number of the motor (0-based).
        step: Step in the coordinate of the robot file [rad or m].
        coarse: Whether it is an effect of its own; else it is a property of the sensor and a part of its noise.
    """

    motor: int
    step: float
    coarse: bool = True


def lattice_step(values: FloatArray) -> float | None:
    """Find the quantisation step of a signal.

    Args:
        values: Signal, shape (n,).

    Returns:
        The step in the unit of the signal; None without quantisation.
    """
    key = blake2b(values.tobytes(), digest_size=16).digest()
    if key not in _KNOWN:  # checks, noise and weights ask for the same signals
        if len(_KNOWN) >= MOST_KNOWN:
            _KNOWN.clear()
        _KNOWN[key] = _found_step(values)
    return _KNOWN[key]


def _found_step(values: FloatArray) -> float | None:
    signal = values[np.isfinite(values)]
    if len(signal) < FEWEST or len(np.unique(signal)) < 3:
        return None
    change = np.abs(np.concatenate([np.diff(signal), np.diff(signal, 2)]))
    exact, largest = 32 * float(np.spacing(np.abs(signal).max())), float(change.max(initial=0.0))
    steps = (_step_of(change, max(exact, rounded * largest)) for rounded in ROUNDED)
    return next((step for step in steps if step is not None), None)


def _step_of(change: FloatArray, resolution: float) -> float | None:
    """Find the step of which differences beyond a resolution are multiples; None without one."""
    change = change[change > resolution]
    if len(change) < FEWEST:
        return None
    some = change[:: max(1, len(change) // SOME)]
    for smallest in np.unique(np.quantile(change, QUANTILES)):
        for divisor in _DIVISORS:
            if _is_none(float(smallest) / divisor, some, resolution):
                continue
            step = _refined(float(smallest) / divisor, change)
            if step > 4 * resolution and _distance(change, step, resolution) < OFF_LATTICE:
                return step
    return None


def _is_none(step: float, some: FloatArray, resolution: float) -> bool:
    """Return whether some differences suffice to see that they are no multiples of a step."""
    step = _refined(step, some)
    distance = _distance(some, step, resolution)
    return bool(np.isfinite(distance)) and distance > 2 * OFF_LATTICE


def encoder_step(record: Record, motor: int) -> float:
    """Return the resolution of an encoder as measured, also where its positions were interpolated since.

    Args:
        record: The record.
        motor: Number of the motor (0-based).

    Returns:
        The step [rad or m]; 0 without quantisation.
    """
    if record.encoder_steps:
        return record.encoder_steps[motor]
    return resolution_of(record.position[record.valid, motor])


def resolution_of(values: FloatArray) -> float:
    """Return the step of a signal, or the usual change of one that hardly ever changes, as an encoder at rest.

    Args:
        values: Signal, shape (n,).

    Returns:
        The step in the unit of the signal; 0 without quantisation.
    """
    step = lattice_step(values)
    change = np.abs(np.diff(values))
    if step is None and np.any(change > 0) and np.mean(change == 0) > AT_REST:
        return float(np.median(change[change > 0]))
    return step or 0.0


def _refined(step: float, change: FloatArray) -> float:
    """Fit the step to increasingly long differences."""
    for most in _MULTIPLES:
        near = change[change < (most + 0.5) * step]
        count = np.rint(near / step)
        if not np.any(count):
            return step
        step = float(near @ count / (count @ count))
    return step


def _distance(change: FloatArray, step: float, resolution: float) -> float:
    """Return the rms distance of the shorter differences from multiples of a step, in steps."""
    short = change[change < (_MULTIPLES[-1] + 0.5) * step]
    if len(short) < FEWEST:
        return float("inf")
    off = short / step - np.rint(short / step)
    beyond = float(np.mean(np.rint(short / step) == 0))
    return float(np.sqrt(np.mean(off**2))) + beyond + resolution / step


def encoder_quantization(record: Record, robot: Robot, coarse: float) -> tuple[Quantization, ...]:
    """Find the encoders whose quantisation is significant compared with their noise.

    Args:
        record: The record; interpolated positions are not quantised any more.
        robot: The robot, for the noise of its encoders.
        coarse: Step over that noise, rms, from which a quantisation is coarse [1].

    Returns:
        Quantisations by motor; empty without one.
    """
    quantizations = []
    for motor in range(robot.n_motors):
        step = lattice_step(record.position[record.valid, motor])
        if step is None or step / np.sqrt(12) < MATTERS * float(robot.encoder_noise[motor]):
            continue
        quantizations.append(Quantization(motor, step, coarse=step > coarse * float(robot.encoder_noise[motor])))
    return tuple(quantizations)
