"""Measured torques that acted earlier or later than their stamps say."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.record.record import Record


def shifted(record: Record, shift: float) -> Record:
    """Return a record whose measured torques act later than they are noted.

    Args:
        record: The log.
        shift: Samples from the stamp of a torque to the middle of the time in which it acts, a multiple of a half.
    """
    if record.effort is None or record.torque_shift == shift:
        return record
    torque = np.where(record.predicted, moved_later(record.effort, shift - 0.5), record.torque)
    return replace(record, torque=torque, torque_shift=shift)


def moved_later(values: FloatArray, samples: float) -> FloatArray:
    """Move rows to later samples; between two samples, their mean. The first or last row is repeated.

    Args:
        values: Shape (n, M).
        samples: By how much [samples], a multiple of a half.
    """
    rows = np.arange(len(values))
    before, after = (values[np.clip(rows - int(turn(samples)), 0, len(values) - 1)] for turn in (np.floor, np.ceil))
    return np.asarray(before if samples == int(samples) else (before + after) / 2)
