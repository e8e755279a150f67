"""Noted torques that acted earlier or later than their stamps say."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.record.record import Record


HELD = 0.5
"""Samples from the stamp of a torque that is held until the next one to the middle of the time in which it acts."""


def timing_is_open(record: Record) -> bool:
    """Return whether torques were noted with the positions, and nothing is known yet of when they acted.

    Args:
        record: The log; only a recorder that is not ours may note torques elsewhere in their sample.
    """
    usual = 0.0 if record.measured_torque else HELD
    if record.noted is None or not record.imported or record.torque_shift != usual:
        return False
    return bool(np.isfinite(record.noted[:, record.predicted]).all())


def shifted(record: Record, shift: float) -> Record:
    """Return a record whose torques act later than they are noted; torques with stamps of their own stay.

    Args:
        record: The log.
        shift: Samples of the recorder from the stamp of a torque to the middle of the time in which it acts, a multiple
            of a half.
    """
    if record.noted is None or record.torque_shift == shift:
        return record
    later = shift / record.recorder_samples - 0.5
    torque = np.where(record.predicted, moved_later(record.noted, later), record.torque)
    return replace(record, torque=torque, torque_shift=shift)


def moved_later(values: FloatArray, samples: float) -> FloatArray:
    """Move rows to later samples, interpolated linearly between two. The first or last row is repeated.

    Args:
        values: Shape (n, M).
        samples: By how much [samples].
    """
    rows, whole = np.arange(len(values)), int(np.floor(samples))
    newer, older = (values[np.clip(rows - whole - age, 0, len(values) - 1)] for age in (0, 1))
    part = samples - whole
    return np.asarray((1 - part) * newer + part * older if part else newer)
