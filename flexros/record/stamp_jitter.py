"""Positions on an even grid: where stamps beside the grid tell the true instants they are interpolated, else not."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError

if TYPE_CHECKING:
    from flexros.arrays import BoolArray, FloatArray
    from flexros.record.even_grid import EvenGrid

NOTED = 0.005
"""Deviation of the stamps from the grid, rms in samples, from which it is looked at (chosen)."""

_SMOOTH = 5  # samples over which speeds are averaged
_BELIEVED = 0.5  # share of the deviation that must be seen in the positions


def positions_on_grid(
    values: FloatArray, grid: EvenGrid, name: str, warnings: list[str]
) -> tuple[FloatArray, BoolArray, bool]:
    """Put measured positions onto the grid, missing ones held.

    Args:
        values: Measured positions, one row per message [rad or m], shape (n, M).
        grid: The grid of their stamps.
        name: Name of the log, for the texts.
        warnings: Receives what was done.

    Returns:
        Positions, shape (n_slots, M); whether each was measured, shape (n_slots,); whether stamps beside the grid tell
        the true instants.

    Raises:
        InputError: No position is finite.
    """
    taken = values[grid.rows]
    finite = np.all(np.isfinite(taken), axis=1)
    if not np.any(finite):
        raise InputError(f"{name}: positions are not finite in any sample; check the topic joint_states")
    place, own = grid.held()
    valid: BoolArray = own & finite[place]
    last = np.maximum.accumulate(np.where(finite, np.arange(len(taken)), -1))
    last = np.where(last < 0, int(np.argmax(finite)), last)
    position: FloatArray = taken[last][place]
    if grid.jitter <= NOTED * grid.sample_time:
        return position, valid, False
    share = seen_share(position, grid, valid)
    amount = f"the stamps of joint_states are {1e6 * grid.jitter:.3g} us rms beside even sampling"
    if not share > _BELIEVED:
        warnings.append(f"{amount}, which the positions do not follow; the samples are taken as even")
        return position, valid, False
    warnings.append(f"{amount} and tell the true instants; the positions were interpolated to even ones")
    from scipy.interpolate import CubicSpline  # here, because it loads slowly

    time = grid.start + grid.sample_time * grid.numbers + grid.deviation
    spline = CubicSpline(time[finite], taken[finite])
    at = np.clip(grid.instants[valid], time[finite][0], time[finite][-1])
    position = position.copy()
    position[valid] = spline(at)
    return position, valid, True


def seen_share(position: FloatArray, grid: EvenGrid, valid: BoolArray) -> float:
    """Find which share of the deviation of the stamps is seen in the positions.

    A sample taken late by d lies off an even one by speed times d: second differences of the positions are regressed
    on those of speed times d.

    Args:
        position: Positions by message on the grid [rad or m], shape (n_slots, M).
        grid: The grid.
        valid: Which were measured, shape (n_slots,).

    Returns:
        Share, about 1 where the stamps tell the true instants and 0 where they do not; 0 where nothing moves.
    """
    deviation = np.zeros(grid.n_slots)
    deviation[grid.numbers] = grid.deviation
    kernel = np.ones(_SMOOTH) / _SMOOTH
    whole = valid[1:-1] & valid[:-2] & valid[2:]
    above, below = 0.0, 0.0
    for column in position.T:
        speed = np.convolve(np.gradient(column, grid.sample_time), kernel, mode="same")
        seen, told = (np.diff(signal, 2)[whole] for signal in (column, speed * deviation))
        noise = float(np.var(seen))
        if noise > 0:
            above += float(seen @ told) / noise
            below += float(told @ told) / noise
    return above / below if below > 0 else 0.0
