"""The part of a log that is fitted, and the part that is held out."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.record.record import Record

AT_REST = 0.01
"""Share of its range within which a position is that of the rest at the begin or end of a log [1] (chosen)."""


def split(record: Record, share: float) -> tuple[Record, Record]:
    """Set the last part of a log aside; of one that rests for all of either part, the last part of its motion.

    A rest confirms nothing: whatever friction an explanation names holds the arm there.

    Args:
        record: The log.
        share: Share of it that is fitted to [1].
    """
    border = int(share * record.n_samples)
    begin, end = _moving(record)
    if end <= border or begin >= border:
        border = begin + int(share * (end - begin))
    return record.part(0, border), record.part(border, record.n_samples)


def _moving(record: Record) -> tuple[int, int]:
    """Return the samples between which a log moves: all of it where it does not."""
    position, rows = record.position[record.valid], np.flatnonzero(record.valid)
    if not len(rows):
        return 0, record.n_samples
    near = AT_REST * np.ptp(position, axis=0)
    begun = np.flatnonzero(np.any(np.abs(position - position[0]) > near, axis=1))
    going = np.flatnonzero(np.any(np.abs(position - position[-1]) > near, axis=1))
    if not len(begun):
        return 0, record.n_samples
    return int(rows[begun[0]]), int(rows[going[-1]]) + 1
