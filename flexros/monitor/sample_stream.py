"""Even windows from messages: states and commands are paired by their stamps.

Limits of rates and of missing samples are those of `flexros.record`. The windows do not depend on how the messages are
split into calls, so that the monitor gives the same figures on a running robot and on its log. Memory is bounded:
messages that cannot be paired are dropped.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.monitor.topic_queue import Counts, TopicQueue
from flexros.record.even_grid import HIGHEST_RATE, LOWEST_RATE
from flexros.record.missing_samples import MOST_BRIDGED, bridged, bridged_motion, longest_run

if TYPE_CHECKING:
    from collections.abc import Iterator

    from flexros.arrays import BoolArray, FloatArray, IntArray

WINDOW = 0.1
"""Length of a window [s] (chosen)."""
FIRST = 64
"""States, and commands, from which the sample time is estimated (chosen)."""
AS_NOMINAL = 2e-3
"""Relative difference up to which the nominal sample time, or a rate of whole hertz, is used (chosen): the estimate has
`FIRST` stamps only."""
NEAR = 0.25
"""Distance from a sampling instant up to which a command belongs to it, in samples (chosen)."""
MOST_WAITING = 20.0
"""Time for which messages are kept while the other topic is silent [s] (chosen)."""


@dataclass(frozen=True, eq=False)
class Window:
    """Even samples of a window.

    Attributes:
        stamp: Stamp of its first sample [ns].
        position: Motor positions, interpolated where not measured [rad or m], shape (n, M).
        torque: Mean torque command from each sample to the next [Nm or N], shape (n, M).
        measured: Whether a sample was measured, shape (n,).
        restarted: Whether the window does not continue the one before.
    """

    stamp: int
    position: FloatArray
    torque: FloatArray
    measured: BoolArray
    restarted: bool


@dataclass
class SampleStream:
    """Pairs states and commands.

    Args:
        nominal: Nominal sample time, used where the stamps agree with it [s].
        motors: Number of motors M.

    Attributes:
        counts: Counts of messages and windows.
        sample_time: Time between two samples [s]; 0 while it is not known.
    """

    nominal: float
    motors: int
    counts: Counts = field(default_factory=Counts)
    sample_time: float = 0.0

    def __post_init__(self) -> None:
        self._states, self._commands = TopicQueue.empty(self.motors), TopicQueue.empty(self.motors)
        self._epochs, self._origin, self._next, self._until = (0, 0), 0.0, 0, -1
        self._held = self._restarted = False

    def add_states(self, stamp: IntArray, position: FloatArray) -> None:
        """Add measurements.

        Args:
            stamp: Stamps [ns], shape (n,).
            position: Motor positions [rad or m], shape (n, M).
        """
        self.counts.states += len(stamp)
        self._states.add(stamp, position, self.counts)

    def add_commands(self, stamp: IntArray, torque: FloatArray) -> None:
        """Add commands.

        Args:
            stamp: Stamps [ns], shape (n,).
            torque: Torque commands [Nm or N], shape (n, M).
        """
        self.counts.commands += len(stamp)
        self._commands.add(stamp, torque, self.counts)

    @property
    def samples(self) -> int:
        """Samples of a window."""
        return max(round(WINDOW / self.sample_time), 1)

    @property
    def _both(self) -> tuple[TopicQueue, TopicQueue]:
        return self._states, self._commands

    def windows(self) -> Iterator[Window]:
        """Yield the complete windows.

        Raises:
            InputError: The rate of the states is outside the limits.
        """
        states, commands = self._both
        while self._is_paired():
            end = self._time(self._next + self.samples)
            if min(states.last, commands.last) <= end:
                break
            if (window := self._window(end)) is not None:
                self._until = end
                yield window
        self._bound()

    @property
    def unpaired(self) -> float:
        """Time of the newest states that were not paired with commands [s]."""
        waiting, last = self._states.stamp, self._states.last
        known = 0 <= self._until <= last  # else the stamps were reset
        begin = self._until if known or not len(waiting) else int(waiting[0])
        return max(last - begin, 0) * 1e-9

    def _is_paired(self) -> bool:
        """Return whether states and commands are paired; begin where their stamps meet, again after a jump."""
        if self.sample_time and self._epochs == tuple(topic.epoch for topic in self._both):
            return True
        if any(len(topic.stamp) < FIRST for topic in self._both):
            return False
        first, last = max(topic.stamp[0] for topic in self._both), min(topic.last for topic in self._both)
        if any(np.count_nonzero((first <= topic.stamp) & (topic.stamp <= last)) < FIRST // 2 for topic in self._both):
            return False
        self._begin()
        return True

    def _begin(self) -> None:
        """Estimate sample time and grid from the first states."""
        stamp = self._states.stamp[:FIRST]
        time = (stamp - stamp[0]) * 1e-9
        numbers = np.cumsum(np.rint(np.diff(time, prepend=0.0) / np.median(np.diff(time))))
        step = float(np.polyfit(numbers, time, 1)[0])
        if not 1 / HIGHEST_RATE <= step <= 1 / LOWEST_RATE:
            raise InputError(
                f"joint_states is stamped every {step:.6g} s, which is a rate of {1 / step:.6g} Hz; allowed are "
                f"{LOWEST_RATE:g} Hz to {HIGHEST_RATE:g} Hz: check the stamps"
            )
        rounded = [time for time in (self.nominal, 1 / round(1 / step)) if abs(time / step - 1) < AS_NOMINAL]
        self.sample_time = rounded[0] if rounded else step
        self._epochs = (self._states.epoch, self._commands.epoch)
        self._origin = float(stamp[0])
        self._until = int(stamp[0])
        self._next = 0
        self._restarted = True
        self.counts.restarts += 1
        self._held = self._holds()

    def _holds(self) -> bool:
        """Return whether commands have instants of their own, between which they are held."""
        off = (self._commands.stamp[:FIRST] - self._origin) * 1e-9 / self.sample_time
        sparse = float(np.median(np.diff(off))) > 1.5 if len(off) > 1 else False
        return sparse or float(np.mean(np.abs(off - np.rint(off)) < NEAR)) < 0.9

    def _time(self, slot: int) -> int:
        """Return the time half a sample before a slot [ns], the end of the slots before it."""
        return int(self._origin + (slot - 0.5) * self.sample_time * 1e9)

    def _window(self, end: int) -> Window | None:
        """Return the next window; None where samples or commands are missing."""
        states, commands, n = self._states, self._commands, self.samples
        first, last = int(np.searchsorted(states.stamp, self._time(self._next))), np.searchsorted(states.stamp, end)
        stamp, T = states.stamp[first:last], self.sample_time * 1e9
        slots = (stamp - self._origin) / T - self._next
        numbers = np.clip(np.rint(slots).astype(np.int64), 0, n - 1)
        measured = np.zeros(n, dtype=bool)
        measured[numbers] = True
        self.counts.missing += int(np.count_nonzero(~measured))
        lost = not measured.any() or longest_run(~measured) > MOST_BRIDGED
        torque = None if lost else self._torque(end)
        window = None
        if torque is None:
            self.counts.lost_windows += 1
        else:
            position = np.empty((n, self.motors))
            position[numbers] = states.values[first:last]
            position = bridged_motion(position, measured)
            window = Window(round(self._origin + self._next * T), position, torque, measured, self._restarted)
        self._restarted = torque is None
        self._next += n
        if len(stamp) and abs(off := float(np.median(slots - np.rint(slots)))) > 0.02:
            self._origin += off * T  # clock drift of the robot
        self._skip_silence()
        states.drop_before(self._time(self._next))
        commands.drop_before(self._time(self._next), keep=2)
        return window

    def _torque(self, end: int) -> FloatArray | None:
        """Return the mean torque of every slot; None where it is unknown."""
        n, T = self.samples, self.sample_time * 1e9
        stamp = (self._commands.stamp - self._origin) / T - self._next
        values = self._commands.values
        if self._held:
            last = int(np.searchsorted(self._commands.stamp, end)) + 1  # later ones do not act within the window
            return _held(np.asarray(stamp[:last], dtype=float), values[:last], n)
        rows = (self._commands.stamp >= self._time(self._next)) & (self._commands.stamp < end)
        numbers = np.clip(np.rint(stamp[rows]).astype(np.int64), 0, n - 1)
        known = np.zeros(n, dtype=bool)
        known[numbers] = True
        if not known.any() or longest_run(~known) > MOST_BRIDGED:
            return None
        torque = np.empty((n, self.motors))
        torque[numbers] = values[rows]
        return bridged(torque, known)

    def _skip_silence(self) -> None:
        """Advance to the next window with states."""
        stamp = self._states.stamp[self._states.stamp >= self._time(self._next)]
        if not len(stamp):
            return
        ahead = int((stamp[0] - self._origin) / (self.sample_time * 1e9) - self._next) // self.samples
        if ahead > 0:
            self.counts.lost_windows += ahead
            self._next += ahead * self.samples
            self._restarted = True

    def _bound(self) -> None:
        """Drop messages that have waited too long for the other topic."""
        for topic in self._both:
            if len(topic.stamp) and topic.stamp[-1] - topic.stamp[0] > MOST_WAITING * 1e9:
                topic.drop_before(int(topic.stamp[-1] - MOST_WAITING * 1e9 / 2))
                self._restarted = True


def _held(stamp: FloatArray, values: FloatArray, n: int) -> FloatArray | None:
    """Average held commands over each of n slots; stamps are in samples from the first slot."""
    if len(stamp) < 2 or stamp[0] > 0:
        return None
    if float(np.diff(stamp).max()) > MOST_BRIDGED * max(float(np.median(np.diff(stamp))), 1.0):
        return None
    knots = np.append(stamp, max(n, stamp[-1]) + 1.0)
    area = np.concatenate([np.zeros((1, values.shape[1])), np.cumsum(np.diff(knots)[:, None] * values, axis=0)])
    at = np.arange(n + 1)
    return np.diff(np.stack([np.interp(at, knots, column) for column in area.T], axis=1), axis=0)
