"""Torques of a record at the instants of its positions, as the regression pairs them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.record.missing_samples import bridged
from flexros.record.torques.shifted_torque import HELD, moved_later

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.record.record import Record


def torque_at_samples(record: Record) -> FloatArray:
    """Return the torque of the sample of each position (eq. 4.12).

    Args:
        record: The record.

    Returns:
        The measured torque when it acted, bridged where it is missing, or the command [Nm or N], shape (n, M).
    """
    if record.noted is not None and (record.measured_torque or record.torque_shift != HELD):
        return moved_later(bridged(record.noted, record.valid), record.torque_shift / record.recorder_samples)
    return record.torque


def torque_as_it_acts(record: Record, delay: float) -> tuple[FloatArray, int]:
    """Average commands, delayed and held, over one sample around each position.

    Args:
        record: The record of commands.
        delay: Delay of the command [s].

    Returns:
        Torques [Nm or N], shape (n, M), and the first sample around which commands acted throughout.
    """
    T, n = record.sample_time, record.n_samples
    ends = T * np.arange(n + 1) + delay
    at = T * np.arange(n)
    integral = np.vstack([np.zeros(record.torque.shape[1]), np.cumsum(T * record.torque, axis=0)])
    acting = [(np.interp(at + T / 2, ends, column) - np.interp(at - T / 2, ends, column)) / T for column in integral.T]
    return np.column_stack(acting), min(int(np.ceil(delay / T + 0.5 - 1e-9)), n)
