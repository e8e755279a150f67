"""Parts of a motion in which effects show: standstill, reversal, low and high speed, high torque, early and late."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import BoolArray, FloatArray
    from flexros.gap.where.motion import MotorMotion

FAMILIES = {
    "all": "all",
    "standstill": "speed",
    "reversal": "speed",
    "low speed": "speed",
    "high speed": "speed",
    "vibration": "speed",
    "high torque": "torque",
    "gear torque reversal": "gear torque",
    "high acceleration": "acceleration",
    "first third": "time",
    "last third": "time",
}
"""Regimes and what they are regimes of, in the order in which they are listed."""

STILL = 0.01
"""Share of the largest speed below which a motor counts as standing (chosen)."""
LOW = 0.15
"""Share of the largest speed below which it counts as slow (chosen)."""
HIGH = 0.6
"""Share of the largest speed, torque or acceleration above which it counts as high (chosen)."""
LASTING = 0.08
"""Time between two turnings [s] below which they are a vibration and no reversals (chosen)."""
BEFORE, AFTER = 0.02, 0.06
"""Time before and after a change of sign that belongs to a reversal [s] (chosen; prediction errors come after it)."""


def regimes(motion: MotorMotion, number: int, sample_time: float) -> dict[str, BoolArray]:
    """Tell which samples belong to each regime of a motor.

    Args:
        motion: Motion of the motors.
        number: Number of the motor (0-based).
        sample_time: Time between two samples [s].

    Returns:
        Samples of each regime by its name, shape (n,); all of `FAMILIES`, some of them empty.
    """
    speed, n = motion.speed[:, number], len(motion.speed)
    top = _largest(speed)
    turnings = _turnings(speed, STILL * top)
    lasting = _apart(turnings, round(LASTING / sample_time))
    reversal = around(lasting, sample_time)
    slow = np.abs(speed) < LOW * top
    still = _lasting(np.abs(speed) < STILL * top, round((BEFORE + AFTER) / sample_time)) & ~reversal
    vibration = around(turnings & ~lasting, sample_time) & ~still & ~reversal
    gear = motion.gear_torque[:, number]
    turns = _turnings(np.nan_to_num(gear), STILL * _largest(gear)) if np.isfinite(gear).any() else np.zeros(n, bool)
    time = np.arange(n)
    return {
        "all": np.ones(n, dtype=bool),
        "standstill": still,
        "reversal": reversal,
        "low speed": slow & ~still & ~reversal & ~vibration,
        "high speed": _high(speed) & ~reversal & ~vibration,
        "vibration": vibration,
        "high torque": _high(motion.torque[:, number]),
        "gear torque reversal": around(turns, sample_time),
        "high acceleration": _high(motion.acceleration[:, number]),
        "first third": time < n / 3,
        "last third": time >= 2 * n / 3,
    }


def around(events: BoolArray, sample_time: float) -> BoolArray:
    """Widen single samples to the time around them that belongs to an event.

    Args:
        events: Samples at which something happens, shape (n,).
        sample_time: Time between two samples [s].

    Returns:
        Samples from `BEFORE` before to `AFTER` after an event, shape (n,).
    """
    steps = np.zeros(len(events) + 1)
    rows = np.flatnonzero(events)
    np.add.at(steps, np.maximum(rows - round(BEFORE / sample_time), 0), 1)
    np.add.at(steps, np.minimum(rows + round(AFTER / sample_time) + 1, len(events)), -1)
    return np.asarray(np.cumsum(steps)[:-1] > 0)


def _turnings(values: FloatArray, least: float) -> BoolArray:
    """Find changes of sign between values of at least a size; the sample at which the value passes zero."""
    sign = np.where(values > least, 1, np.where(values < -least, -1, 0))
    rows = np.flatnonzero(sign)
    found = np.zeros(len(values), dtype=bool)
    changes = np.flatnonzero(np.diff(sign[rows]))
    for change in changes:
        first, last = rows[change], rows[change + 1]
        found[first + int(np.abs(values[first : last + 1]).argmin())] = True
    return found


def _apart(events: BoolArray, samples: int) -> BoolArray:
    """Keep the events that are at least so many samples from the ones before and behind."""
    rows = np.flatnonzero(events)
    distance = np.diff(np.concatenate([[-samples], rows, [len(events) + samples]]))
    kept = np.zeros(len(events), dtype=bool)
    kept[rows[(distance[:-1] >= samples) & (distance[1:] >= samples)]] = True
    return kept


def _high(values: FloatArray) -> BoolArray:
    """Find the samples of a size near the largest one; that of rest (gravity, friction) does not count."""
    size = np.abs(values - np.median(values))
    return np.asarray(size > HIGH * max(_largest(size), 1e-300))


def _largest(values: FloatArray) -> float:
    """Return the size that 0.1 % of the samples exceed."""
    return float(np.quantile(np.abs(values[np.isfinite(values)]), 0.999))


def _lasting(held: BoolArray, samples: int) -> BoolArray:
    """Keep only stretches of at least so many samples."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], held.astype(int), [0]])))
    kept = np.zeros(len(held), dtype=bool)
    for first, end in zip(edges[::2], edges[1::2]):
        kept[first:end] = end - first >= samples
    return kept
