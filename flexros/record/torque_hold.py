"""Torque that acted from each sampling instant to the next, from commands that are held or torques that are sampled."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.record.held_commands import EVEN, LONGEST_HELD, HeldCommands

if TYPE_CHECKING:
    from flexros.arrays import BoolArray, FloatArray, IntArray
    from flexros.record.even_grid import EvenGrid

_SHARED = 0.5
"""Share of the measurements with a command of the same stamp from which a command is expected with each (chosen)."""


@dataclass(frozen=True, eq=False)
class HeldTorque:
    """Torque of each slot of a grid.

    Attributes:
        torque: Mean from each slot to the next [Nm or N], shape (n_slots, M).
        known: Whether the torque is known there, shape (n_slots,).
        late: Whether it has no command of its own, so that the one before stands there, shape (n_slots,).
        first: First slot whose torque is known from its beginning.
        end: Slot behind the last one that a command still covers.
        warnings: What was noticed, a sentence each.
    """

    torque: FloatArray
    known: BoolArray
    late: BoolArray
    first: int
    end: int
    warnings: tuple[str, ...] = ()


def held_torque(
    stamp: IntArray, effort: FloatArray, grid: EvenGrid, true_instants: bool, states: IntArray
) -> HeldTorque:
    """Take the mean of held commands over each sample (zero-order hold from the stamp of each).

    Commands that share the stamps of the measurements belong to their slots, unless these stamps tell the true
    instants; others act for the part of the sample in which they are the last.

    Args:
        stamp: Stamps of the commands [ns], increasing, shape (k,).
        effort: Commands [Nm or N], shape (k, M).
        grid: The grid of the measurements.
        true_instants: Whether stamps beside the grid tell the true instants.
        states: Stamps of the measurements [ns], shape (n,).

    Returns:
        The torque.
    """
    shared = np.isin(states[grid.rows], stamp)
    if shared.mean() > _SHARED and not true_instants:
        return _slot_by_slot(stamp, effort, grid, states)
    time = (stamp - grid.origin) * 1e-9
    begin = grid.instants
    T = grid.sample_time
    ends = np.append(time, max(time[-1], begin[-1] + T) + T)
    integral = np.vstack([np.zeros(effort.shape[1]), np.cumsum(np.diff(ends)[:, None] * effort, axis=0)])
    columns = [(np.interp(begin + T, ends, column) - np.interp(begin, ends, column)) / T for column in integral.T]
    usual = max(T, float(np.median(np.diff(time)))) if len(time) > 1 else T
    first = int(np.searchsorted(begin, time[0] - EVEN * T))
    end = int(np.searchsorted(begin, time[-1] + usual, side="right"))
    place = np.clip(np.searchsorted(time, begin + EVEN * T, side="right") - 1, 0, len(time) - 1)
    return _with_holes(np.column_stack(columns), begin - time[place], usual, T, first, min(end, len(begin)))


def _slot_by_slot(stamp: IntArray, effort: FloatArray, grid: EvenGrid, states: IntArray) -> HeldTorque:
    """Give each slot the command with the stamp of its measurement, else the one before."""
    ticks = np.rint((grid.start + grid.sample_time * np.arange(grid.n_slots)) * 1e9).astype(np.int64) + grid.origin
    ticks[grid.numbers] = states[grid.rows]
    held = HeldCommands.of(stamp, ticks + 1)  # a slot without a measurement is known to the nanosecond only
    end = int(np.searchsorted(ticks, stamp[-1], side="right"))
    age = (ticks - stamp[np.maximum(held.place, 0)]) * 1e-9
    T = grid.sample_time
    return _with_holes(held.values(effort), age, 0.0, T, held.first, end)


def _with_holes(
    torque: FloatArray, age: FloatArray, usual: float, sample_time: float, first: int, end: int
) -> HeldTorque:
    """Mark what was held longer than a controller holds, `usual` [s] is no hold: there the recorder lost commands."""
    allowed = usual + LONGEST_HELD * sample_time
    known = age <= allowed
    known[:first], known[end:] = False, False
    warnings = []
    late = age > usual + 0.5 * sample_time
    late[:first], late[end:] = False, False
    if late.any():
        worst = float(age[first:end].max())
        warnings.append(
            f"{np.count_nonzero(late)} samples have no command of their own, so the command before was held (up to "
            f"{1e3 * worst:.3g} ms); where that is longer than {1e3 * allowed:.3g} ms the samples count as not measured"
        )
    return HeldTorque(torque, known, late, first, end, tuple(warnings))


def sampled_torque(effort: FloatArray, grid: EvenGrid) -> HeldTorque:
    """Take the mean of torques measured at the beginning and the end of each sample.

    Args:
        effort: Measured torques, one row per measurement [Nm or N], shape (n, M).
        grid: The grid of the measurements.

    Returns:
        The torque; that of the last slot is the measured one.
    """
    place, own = grid.held()
    values = effort[grid.rows][place]
    mean = values.copy()
    mean[:-1] = (values[:-1] + values[1:]) / 2
    known = own & np.append(own[1:], True)
    return HeldTorque(mean, known, np.zeros(len(values), dtype=bool), 0, len(values))
