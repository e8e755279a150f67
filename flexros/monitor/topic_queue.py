"""Messages of one topic that wait for those of another, by their stamps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray

JUMP = 1_000_000_000
"""Stamps that go back by more than this begin anew; less is a message that came late [ns] (chosen)."""


@dataclass
class Counts:
    """What happened to the messages.

    Attributes:
        states: States taken.
        commands: Commands taken.
        late: Messages that were stamped no later than one before them: repeated, or out of order.
        unusable: Messages with a value that is not finite.
        missing: States that are missing.
        lost_windows: Windows that could not be put together.
        restarts: Times that the stream began anew.
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
    """Messages of a topic that wait, stamps increasing.

    Attributes:
        stamp: Stamps [ns], shape (n,).
        values: Values, shape (n, M).
        last: Latest stamp that was taken [ns].
        epoch: Times that the stamps have jumped back.
    """

    stamp: IntArray
    values: FloatArray
    last: int = -1
    epoch: int = 0

    @classmethod
    def empty(cls, motors: int) -> TopicQueue:
        """Make a queue for values of so many motors."""
        return cls(np.zeros(0, dtype=np.int64), np.zeros((0, motors)))

    def add(self, stamp: IntArray, values: FloatArray, counts: Counts) -> None:
        """Take messages; begin anew where stamps jump back."""
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
