"""Positions on an even grid, interpolated where jittering stamps are the true sampling instants."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.record.even_grid import NOTED_JITTER
from flexros.record.local_cubic import local_cubic

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import BoolArray, FloatArray
    from flexros.record.even_grid import EvenGrid

SLIGHT, EVEN = "deviate from even sampling by", "which the positions do not follow; the samples are treated as even"
"""Words of the warning of jitter that does not matter."""

_SMOOTH = 5  # samples over which speeds are averaged
_BELIEVED = 0.5  # share of the deviation that must be visible in the positions
_FEWEST = 100  # samples from which velocities tell
_ALIKE = 0.9  # correlation of a measured speed with the derivative of its position from which it tells
_CLOSER = 0.8  # error of the speeds with the true instants, over that with the others, from which they tell which


def positions_on_grid(
    values: FloatArray, grid: EvenGrid, name: str, warnings: list[str], velocity: FloatArray | None = None
) -> tuple[FloatArray, BoolArray, bool]:
    """Place measured positions on the grid; missing ones are held.

    Args:
        values: Measured positions, one row per message [rad or m], shape (n, M).
        grid: The grid of their stamps.
        name: Name of the log, for messages.
        warnings: Receives what was repaired.
        velocity: Measured velocities of the same messages [rad/s or m/s], shape (n, M); None without them.

    Returns:
        Positions, shape (n_slots, M); whether each was measured, shape (n_slots,); whether the stamps are the true
        instants although they jitter.

    Raises:
        InputError: No position is finite.
    """
    taken = values[grid.rows]
    finite = np.all(np.isfinite(taken), axis=1)
    if not np.any(finite):
        raise InputError(f"{name}: positions are not finite in any sample; check the topic joint_states")
    index, own = grid.held()
    valid: BoolArray = own & finite[index]
    last = np.maximum.accumulate(np.where(finite, np.arange(len(taken)), -1))
    last = np.where(last < 0, int(np.argmax(finite)), last)
    position: FloatArray = taken[last][index]
    if grid.jitter <= NOTED_JITTER * grid.sample_time:
        return position, valid, False
    believed = None if velocity is None else shown_by_speeds(taken, velocity[grid.rows], grid)
    if believed is None:
        believed = seen_share(position, grid, valid) > _BELIEVED
    amount = _amount(grid)
    if not believed:
        warnings.append(f"{amount}, {EVEN}")
        return position, valid, False
    warnings.append(f"{amount} and are the true instants; the positions were interpolated to even ones")
    time, valid = grid.times[finite], grid.near(finite)
    position = position.copy()
    position[valid] = local_cubic(time, taken[finite], np.clip(grid.instants[valid], time[0], time[-1]))
    return position, valid, True


def slight_last(warnings: Sequence[str]) -> tuple[str, ...]:
    """Put the warning of jitter that does not matter behind all others, once for all logs.

    Args:
        warnings: Warnings, one sentence each.
    """
    slight = [text for text in warnings if SLIGHT in text and EVEN in text]
    return (*(text for text in warnings if text not in slight), *slight[:1])


def _amount(grid: EvenGrid) -> str:
    """Say how far the stamps are from even sampling."""
    if not grid.irregular:
        return f"the stamps of joint_states {SLIGHT} {1e6 * grid.jitter:.3g} us rms"
    low, high = 1e3 * np.quantile(np.diff(grid.times), (0.01, 0.99))
    return (
        f"the stamps of joint_states are irregular ({low:.3g} to {high:.3g} ms apart, {1 / grid.sample_time:.5g} Hz in "
        "the mean)"
    )


def shown_by_speeds(position: FloatArray, velocity: FloatArray, grid: EvenGrid) -> bool | None:
    """Return whether measured velocities say that the stamps are the true instants; None where they do not tell.

    They are the derivatives of the positions by the true instants. Positions alone show stamps that jitter, and nothing
    of a rate that changes slowly.

    Args:
        position: Positions of the messages that are used [rad or m], shape (m, M).
        velocity: Their measured velocities [rad/s or m/s], shape (m, M).
        grid: The grid.
    """
    errors, follows = np.zeros(2), np.concatenate([[False], np.diff(grid.numbers) == 1])
    for column, speed in zip(position.T, velocity.T, strict=True):
        usable = np.isfinite(column) & np.isfinite(speed) & follows
        if usable.sum() < _FEWEST:
            continue
        derivatives = [np.gradient(column, instants)[usable] for instants in (grid.times, grid.instants[grid.numbers])]
        own = speed[usable]
        if not (np.std(own) > 0 and min(np.std(one) for one in derivatives) > 0):
            continue
        if max(np.corrcoef(own, one)[0, 1] for one in derivatives) > _ALIKE:
            errors += [float(np.mean((one - own) ** 2) / np.var(own)) for one in derivatives]
    by_stamps, even = np.sqrt(errors)
    if by_stamps < _CLOSER * even:
        return True
    return False if even < _CLOSER * by_stamps else None


def seen_share(position: FloatArray, grid: EvenGrid, valid: BoolArray) -> float:
    """Estimate the share of the deviation of the stamps that is visible in the positions.

    A sample taken late by d differs from an even one by speed times d. Second differences of the positions are
    regressed on those of speed times d.

    Args:
        position: Positions by message on the grid [rad or m], shape (n_slots, M).
        grid: The grid.
        valid: Which were measured, shape (n_slots,).

    Returns:
        Share, about 1 where the stamps are the true instants and 0 where they are not; 0 where nothing moves.
    """
    deviation = np.zeros(grid.n_slots)
    deviation[grid.numbers] = grid.deviation
    kernel = np.ones(_SMOOTH) / _SMOOTH
    whole = valid[1:-1] & valid[:-2] & valid[2:]
    numerator, denominator = 0.0, 0.0
    for column in position.T:
        speed = np.convolve(np.gradient(column, grid.sample_time), kernel, mode="same")
        measured, expected = (np.diff(signal, 2)[whole] for signal in (column, speed * deviation))
        noise = float(np.var(measured))
        if noise > 0:
            numerator += float(measured @ expected) / noise
            denominator += float(expected @ expected) / noise
    return numerator / denominator if denominator > 0 else 0.0
