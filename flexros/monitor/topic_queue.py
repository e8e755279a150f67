"""Queue of the messages of one topic, ordered by stamp."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray

JUMP = 1_000_000_000
"""Backward jump of the stamps that counts as a reset; a smaller one is a late message [ns] (chosen)."""


@dataclass
class Counts:
    """Counts of messages and windows.

    Attributes:
        states: States received.
        commands: Commands received.
        late: Messages stamped no later than one before them: repeated, or out of order.
        unusable: Messages with a value that is not finite.
        missing: States that are missing.
        lost_windows: Windows with missing samples or commands.
        restarts: Number of starts of the stream.
    """

    states: int = 0
    commands: int = 0
    late: int = 0
    unusable: int = 0
    missing: int = 0
    lost_windows: int = 0
    restarts: int = 0


@dataclass
class TopicQueue:
    """Waiting messages of a topic, stamps increasing.

    Attributes:
        stamp: Stamps [ns], shape (n,).
        values: Values, shape (n, M).
        last: Latest stamp received [ns].
        epoch: Number of resets of the stamps.
    """

    stamp: IntArray
    values: FloatArray
    last: int = -1
    epoch: int = 0

    @classmethod
    def empty(cls, motors: int) -> TopicQueue:
        """Return an empty queue for a number of motors."""
        return cls(np.zeros(0, dtype=np.int64), np.zeros((0, motors)))

    def add(self, stamp: IntArray, values: FloatArray, counts: Counts) -> None:
        """Add messages; discard the older ones where stamps jump back."""
        while len(stamp):
            before = np.maximum.accumulate(np.concatenate([[self.last], stamp]))[:-1]
            back = np.flatnonzero(stamp < before - JUMP)
            end = int(back[0]) if back.size else len(stamp)
            new, finite = stamp[:end] > before[:end], np.isfinite(values[:end]).all(axis=1)
            counts.late += int(np.count_nonzero(~new))
            counts.unusable += int(np.count_nonzero(new & ~finite))
            keep = new & finite
            self.stamp = np.concatenate([self.stamp, stamp[:end][keep]])
            self.values = np.concatenate([self.values, values[:end][keep]])
            self.last = max(self.last, int(self.stamp[-1]) if len(self.stamp) else -1)
            stamp, values = stamp[end:], values[end:]
            if back.size:
                self.stamp, self.values, self.last = self.stamp[:0], self.values[:0], -1
                self.epoch += 1

    def drop_before(self, time: int, keep: int = 0) -> None:
        """Drop messages stamped before a time [ns], but the last few of them."""
        first = max(int(np.searchsorted(self.stamp, time)) - keep, 0)
        self.stamp, self.values = self.stamp[first:], self.values[first:]
