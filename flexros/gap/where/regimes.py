"""Regimes: parts of a motion in which effects show, e.g. standstill, reversal, high speed, high torque."""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.arrays import BoolArray, FloatArray
    from flexros.gap.where.motion import MotorMotion


@dataclass(frozen=True)
class Regime:
    """A regime of a motor.

    Attributes:
        kind: Quantity that it is a part of.
        phrase: How it reads in a sentence.
    """

    kind: str
    phrase: str


REGIMES: Mapping[str, Regime] = MappingProxyType(
    {
        "all": Regime("all", ""),
        "standstill": Regime("speed", "at standstill"),
        "reversal": Regime("speed", "at reversals"),
        "low speed": Regime("speed", "at low speed"),
        "high speed": Regime("speed", "at high speed"),
        "vibration": Regime("speed", "in vibration"),
        "high torque": Regime("torque", "under high torque"),
        "gear torque reversal": Regime("gear torque", "where the gear torque changes its sign"),
        "high acceleration": Regime("acceleration", "under high acceleration"),
        "first third": Regime("time", "in the first third of the log"),
        "last third": Regime("time", "in the last third of the log"),
    }
)
"""All regimes in the order in which they are listed."""

STILL = 0.01
"""Share of the largest speed below which a motor counts as standing still (chosen)."""
LOW = 0.15
"""Share of the largest speed below which it counts as slow (chosen)."""
HIGH = 0.6
"""Share of the largest speed, torque or acceleration above which it counts as high (chosen)."""
LASTING = 0.08
"""Time between two changes of direction [s] below which they are a vibration, not reversals (chosen)."""
BEFORE, AFTER = 0.02, 0.06
"""Time before and after a change of sign that belongs to a reversal [s] (chosen; prediction errors follow it)."""


def regimes(motion: MotorMotion, motor: int, sample_time: float) -> dict[str, BoolArray]:
    """Determine the samples of each regime of a motor.

    Args:
        motion: Motion of the motors.
        motor: Index of the motor.
        sample_time: Time between two samples [s].

    Returns:
        Samples of each of the `REGIMES` by name, some of them empty, shape (n,).
    """
    speed, n = motion.speed[:, motor], len(motion.speed)
    top = _largest(speed)
    turnings = _sign_changes(speed, STILL * top)
    reversals = _isolated(turnings, round(LASTING / sample_time))
    reversal = around(reversals, sample_time)
    slow = np.abs(speed) < LOW * top
    still = _lasting(np.abs(speed) < STILL * top, round((BEFORE + AFTER) / sample_time)) & ~reversal
    vibration = around(turnings & ~reversals, sample_time) & ~still & ~reversal
    gear = motion.gear_torque[:, motor]
    changes = (
        _sign_changes(np.nan_to_num(gear), STILL * _largest(gear)) if np.isfinite(gear).any() else np.zeros(n, bool)
    )
    time = np.arange(n)
    return {
        "all": np.ones(n, dtype=bool),
        "standstill": still,
        "reversal": reversal,
        "low speed": slow & ~still & ~reversal & ~vibration,
        "high speed": _high(speed) & ~reversal & ~vibration,
        "vibration": vibration,
        "high torque": _high(motion.torque[:, motor]),
        "gear torque reversal": around(changes, sample_time),
        "high acceleration": _high(motion.acceleration[:, motor]),
        "first third": time < n / 3,
        "last third": time >= 2 * n / 3,
    }


def around(events: BoolArray, sample_time: float) -> BoolArray:
    """Widen events to the time around them.

    Args:
        events: Samples of the events, shape (n,).
        sample_time: Time between two samples [s].

    Returns:
        Samples from `BEFORE` before to `AFTER` after an event, shape (n,).
    """
    steps = np.zeros(len(events) + 1)
    rows = np.flatnonzero(events)
    np.add.at(steps, np.maximum(rows - round(BEFORE / sample_time), 0), 1)
    np.add.at(steps, np.minimum(rows + round(AFTER / sample_time) + 1, len(events)), -1)
    return np.asarray(np.cumsum(steps)[:-1] > 0)


def _sign_changes(values: FloatArray, least: float) -> BoolArray:
    """Find the zero crossings between values of at least a given size."""
    sign = np.where(values > least, 1, np.where(values < -least, -1, 0))
    rows = np.flatnonzero(sign)
    crossings = np.zeros(len(values), dtype=bool)
    changes = np.flatnonzero(np.diff(sign[rows]))
    for change in changes:
        first, last = rows[change], rows[change + 1]
        crossings[first + int(np.abs(values[first : last + 1]).argmin())] = True
    return crossings


def _isolated(events: BoolArray, samples: int) -> BoolArray:
    """Keep the events that are at least `samples` from the previous and the next one."""
    rows = np.flatnonzero(events)
    distance = np.diff(np.concatenate([[-samples], rows, [len(events) + samples]]))
    kept = np.zeros(len(events), dtype=bool)
    kept[rows[(distance[:-1] >= samples) & (distance[1:] >= samples)]] = True
    return kept


def _high(values: FloatArray) -> BoolArray:
    """Find the samples near the largest deviation from the median, which removes gravity."""
    size = np.abs(values - np.median(values))
    return np.asarray(size > HIGH * max(_largest(size), 1e-300))


def _largest(values: FloatArray) -> float:
    """Return the size that 0.1 % of the samples exceed."""
    return float(np.quantile(np.abs(values[np.isfinite(values)]), 0.999))


def _lasting(held: BoolArray, samples: int) -> BoolArray:
    """Keep only stretches of at least `samples` samples."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], held.astype(int), [0]])))
    kept = np.zeros(len(held), dtype=bool)
    for first, end in zip(edges[::2], edges[1::2]):
        kept[first:end] = end - first >= samples
    return kept
