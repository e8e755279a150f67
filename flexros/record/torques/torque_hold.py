"""Torque that acted from each sampling instant to the next: commands that are held, or measured torques."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.record.missing_samples import MOST_BRIDGED

if TYPE_CHECKING:
    from flexros.arrays import BoolArray, FloatArray, IntArray
    from flexros.record.even_grid import EvenGrid

_SHARED = 0.5
"""Share of measurements with a command of the same stamp above which every one is expected to have one (chosen)."""

_DENSE = 0.75
"""Time between two commands, in samples, below which there are some between the measurements (chosen)."""

_SAME_INSTANT = 1e-3  # distance, in samples, up to which two stamps count as the same instant


@dataclass(frozen=True, eq=False)
class HeldCommands:
    """The command that was held at each measurement: the last one that is not later.

    Attributes:
        row: Row of the command, shape (n,); -1 where none came before.
        first: Row of the first measurement with a command; n where there is none.
    """

    row: IntArray
    first: int

    @classmethod
    def of(cls, commands: IntArray, measurements: IntArray) -> HeldCommands:
        """Find the held commands by stamps or sample numbers.

        Args:
            commands: Stamps of the commands, increasing, shape (k,).
            measurements: Stamps of the measurements, increasing, in the same unit, shape (n,).
        """
        row = np.searchsorted(commands, measurements, side="right") - 1
        return cls(row, int(np.searchsorted(row, 0)))

    def values(self, commands: FloatArray) -> FloatArray:
        """Return the command at each measurement; before `first`, the first command, which did not act yet.

        Args:
            commands: Values of the commands, shape (k,) or (k, M).

        Returns:
            Values, shape (n,) or (n, M).
        """
        return np.asarray(commands[np.maximum(self.row, 0)])


@dataclass(frozen=True, eq=False)
class HeldTorque:
    """Torque of each slot of a grid.

    Attributes:
        torque: Mean from each slot to the next [Nm or N], shape (n_slots, M).
        known: Whether the torque is known there, shape (n_slots,).
        late: Whether it has no command of its own, so that the one before is held, shape (n_slots,).
        first: First slot whose torque is known from its beginning.
        end: Slot after the last one that a command covers.
        warnings: What is doubtful, one sentence each.
        noted: Torque as it was noted with each slot [Nm or N], shape (n_slots, M); None where it has stamps of its own.
    """

    torque: FloatArray
    known: BoolArray
    late: BoolArray
    first: int
    end: int
    warnings: tuple[str, ...] = ()
    noted: FloatArray | None = None


def held_torque(
    stamp: IntArray, effort: FloatArray, grid: EvenGrid, true_instants: bool, states: IntArray
) -> HeldTorque:
    """Average held commands over each sample (zero-order hold from the stamp of each).

    Commands that share the stamps of the measurements belong to their slots, unless jittering stamps are the true
    instants or there are commands between the measurements. Others act for the part of the sample in which they are the
    last.

    Args:
        stamp: Stamps of the commands [ns], increasing, shape (k,).
        effort: Commands [Nm or N], shape (k, M).
        grid: The grid of the measurements.
        true_instants: Whether jittering stamps are the true instants.
        states: Stamps of the measurements [ns], shape (n,).

    Returns:
        The torque.
    """
    measured = states[grid.rows]
    shared = stamp[np.minimum(np.searchsorted(stamp, measured), len(stamp) - 1)] == measured
    between = len(stamp) > 1 and float(np.median(np.diff(stamp))) * 1e-9 < _DENSE * grid.sample_time
    if shared.mean() > _SHARED and not true_instants and not between:
        return _slot_by_slot(stamp, effort, grid, states)
    usable = np.all(np.isfinite(effort), axis=1)
    if usable.any():  # a command that is no number was lost: the one before is held
        stamp, effort = stamp[usable], effort[usable]
    time = (stamp - grid.origin) * 1e-9
    begin = grid.instants
    T = grid.sample_time
    ends = np.append(time, max(time[-1], begin[-1] + T) + T)
    integral = np.vstack([np.zeros(effort.shape[1]), np.cumsum(np.diff(ends)[:, None] * effort, axis=0)])
    columns = [(np.interp(begin + T, ends, column) - np.interp(begin, ends, column)) / T for column in integral.T]
    usual = max(T, float(np.median(np.diff(time)))) if len(time) > 1 else T
    first = int(np.searchsorted(begin, time[0] - _SAME_INSTANT * T))
    end = int(np.searchsorted(begin, time[-1] + usual, side="right"))
    last = np.clip(np.searchsorted(time, begin + _SAME_INSTANT * T, side="right") - 1, 0, len(time) - 1)
    return _with_holes(np.column_stack(columns), begin - time[last], usual, T, first, min(end, len(begin)))


def _slot_by_slot(stamp: IntArray, effort: FloatArray, grid: EvenGrid, states: IntArray) -> HeldTorque:
    """Assign to each slot the command with the stamp of its measurement, else the one before."""
    ticks = np.rint((grid.start + grid.sample_time * np.arange(grid.n_slots)) * 1e9).astype(np.int64) + grid.origin
    ticks[grid.numbers] = states[grid.rows]
    held = HeldCommands.of(stamp, ticks + 1)  # slots without a measurement are known to 1 ns
    end = int(np.searchsorted(ticks, stamp[-1], side="right"))
    age = (ticks - stamp[np.maximum(held.row, 0)]) * 1e-9
    T = grid.sample_time
    values = held.values(effort)
    return replace(_with_holes(values, age, 0.0, T, held.first, end), noted=values)


def _with_holes(
    torque: FloatArray, age: FloatArray, usual: float, sample_time: float, first: int, end: int
) -> HeldTorque:
    """Mark samples whose command is older than the `usual` age [s]: there the recorder lost commands."""
    allowed = usual + MOST_BRIDGED * sample_time
    known = age <= allowed
    known[:first], known[end:] = False, False
    warnings = []
    late = age > usual + 0.5 * sample_time
    late[:first], late[end:] = False, False
    if late.any():
        worst = float(age[first:end].max())
        warnings.append(
            f"{np.count_nonzero(late)} samples have no command of their own, so the command before was held (up to "
            f"{1e3 * worst:.3g} ms); samples where it is older than {1e3 * allowed:.3g} ms do not count"
        )
    return HeldTorque(torque, known, late, first, end, tuple(warnings))


def sampled_torque(effort: FloatArray, grid: EvenGrid, true_instants: bool = False) -> HeldTorque:
    """Average the torques measured at the beginning and the end of each sample.

    Args:
        effort: Measured torques, one row per measurement [Nm or N], shape (n, M).
        grid: The grid of the measurements.
        true_instants: Whether stamps off the grid are the true instants, so that torques are interpolated to it.

    Returns:
        The torque; in the last slot it is the measured one.
    """
    index, own = grid.held()
    values = effort[grid.rows][index]
    finite = np.all(np.isfinite(effort[grid.rows]), axis=1)
    if true_instants and finite.any():
        values, own = grid.interpolated(effort[grid.rows]), grid.near(finite)
    mean = values.copy()
    mean[:-1] = (values[:-1] + values[1:]) / 2
    known = own & np.append(own[1:], True)
    return HeldTorque(mean, known, np.zeros(len(values), dtype=bool), 0, len(values))
