"""Positions of encoders that begin again behind the end of their range, as of joints that turn on and on."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.arrays import BoolArray, FloatArray
    from flexros.logs.time_series import JointSeries, Log

JUMP = 0.7
"""Least step between two samples over the range of the positions where they begin again [1] (chosen)."""
USUAL = 0.25
"""Largest of all other steps over it [1] (chosen)."""
MOST = 0.05
"""Largest share of steps where they begin again [1] (chosen): of more, motion and jumps cannot be told apart."""
ALIKE = 0.02
"""Largest difference of two ranges over the range, and of one from a usual number [1] (chosen)."""
TURNS = (2 * np.pi, 360.0)
"""Ranges of which one jump suffices: a turn [rad or deg]. Others take two, as an encoder is reset by any step."""


def wrap_period(values: FloatArray) -> float | None:
    """Return the range after which positions begin again; None where they do not.

    They step over nearly their whole range, against the motion before and behind, and by the same range each time.

    Args:
        values: Positions in any unit, shape (n,).
    """
    finite = values[np.isfinite(values)]
    steps = np.diff(finite)
    span = float(np.ptp(finite)) if len(steps) > 2 else 0.0
    jumps = np.flatnonzero(np.abs(steps) > JUMP * span)
    usual = np.delete(steps, jumps)
    if not span or not 0 < len(jumps) <= max(MOST * len(steps), 1) or np.abs(usual).max() > USUAL * span:
        return None
    around = [usual[max(0, at - number - 1) : at - number + 1] for number, at in enumerate(jumps)]
    motion = np.array([part.mean() if len(part) else 0.0 for part in around])
    ranges = np.abs(motion - steps[jumps])
    period = float(np.median(ranges))
    if np.abs(ranges - period).max() > ALIKE * period:
        return None
    turn = next((turn for turn in TURNS if abs(period / turn - 1) < ALIKE), None)
    if turn is not None or len(jumps) < 2:
        return turn
    if np.diff(np.unique(finite)).max() > USUAL * span:
        return None  # a motor at rest, whose encoder toggles between two steps
    rounded = float(f"{period:.2g}")
    return rounded if abs(rounded / period - 1) < ALIKE / 4 else period


def joined(values: FloatArray, period: float, used: BoolArray | None = None) -> FloatArray:
    """Return positions that go on where they begin again; those that are not finite or used stay.

    Args:
        values: Positions in any unit, shape (n,).
        period: Range after which they begin again, in their unit.
        used: Which ones are used, shape (n,); None for all.
    """
    whole, rows = values.copy(), np.isfinite(values) if used is None else used & np.isfinite(values)
    whole[rows] = np.unwrap(values[rows], period=period)
    return whole


def with_joined_positions(log: Log, warnings: list[str]) -> Log:
    """Join the positions of joints that begin again, with those commanded and planned.

    Args:
        log: The log.
        warnings: Where what was joined is added, one sentence for each joint.
    """
    states = log.joint_states
    assert states.position is not None
    periods = {name: wrap_period(values) for name, values in zip(states.names, states.position.T, strict=True)}
    wrapped = {name: period for name, period in periods.items() if period is not None}
    if not wrapped:
        return log
    for name, period in wrapped.items():
        warnings.append(
            f"the positions of {name} begin again after {period:.4g} and were joined: it turned on; where the encoder "
            "was reset instead, cut the log there"
        )
    commands, reference = log.joint_commands, log.joint_reference
    return replace(
        log,
        joint_states=_with_joined(states, wrapped, states),
        joint_commands=None if commands is None else _with_joined(commands, wrapped, states),
        joint_reference=None if reference is None else _with_joined(reference, wrapped, states),
    )


def _with_joined(series: JointSeries, periods: Mapping[str, float], states: JointSeries) -> JointSeries:
    """Join the positions of a series, in the turn in which those measured begin."""
    if series.position is None or states.position is None:
        return series
    position = series.position.copy()
    for name in periods.keys() & set(series.names):
        column, period = series.names.index(name), periods[name]
        whole = joined(position[:, column], period)
        measured = joined(states.position[:, states.names.index(name)], period)
        known, seen = np.isfinite(whole), np.isfinite(measured)
        if known.any() and seen.any():
            first = int(np.argmax(known))
            begin = np.interp(series.stamp[first], states.stamp[seen], measured[seen])
            position[:, column] = whole - np.rint((whole[first] - begin) / period) * period
    return replace(series, position=position)
