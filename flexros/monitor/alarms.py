"""Alarms: mean squares over several lengths against their thresholds, held for some seconds."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING

import numpy as np

from flexros.monitor.sample_stream import WINDOW
from flexros.monitor.thresholds import LENGTHS

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.monitor.thresholds import Thresholds

HOLD = 10.0
"""Time for which an alarm is held after the last mean square beyond its threshold [s] (chosen): the longest length."""


class Level(IntEnum):
    """State of a motor; the numbers are those of diagnostic_msgs."""

    OK = 0
    WARNING = 1
    ALARM = 2


@dataclass(frozen=True)
class MotorAlarm:
    """State of a motor.

    Attributes:
        level: Alarm, warning or none.
        since: Stamp of its beginning [ns]; -1 where there is none.
        share: Largest mean square on the scale from noise, 0, to its alarm threshold, 1 [1].
    """

    level: Level
    since: int
    share: float


class Alarms:
    """Evaluates windows one after the other.

    Args:
        thresholds: Thresholds.

    Attributes:
        raised: Number of alarms of the robot as a whole.
        warned: Number of its warnings and alarms.
    """

    def __init__(self, thresholds: Thresholds) -> None:
        self._thresholds = thresholds
        motors = thresholds.alarm.shape[1] // 2
        self._sums = np.zeros((len(LENGTHS), 2 * motors))
        self._windows = 0
        self._shares = np.zeros((len(LENGTHS), 2 * motors))
        self._begun = np.full((3, motors), -1, dtype=np.int64)
        self._last = np.full((3, motors), -1, dtype=np.int64)
        self.raised = self.warned = 0

    def restart(self) -> None:
        """Discard sums that a restart has interrupted; alarms are held."""
        self._sums[:] = 0.0
        self._windows = 0

    def forget(self) -> None:
        """Discard alarms, because the clock was reset."""
        self._last[:] = -1

    def take(self, stamp: int, values: FloatArray) -> None:
        """Evaluate a window.

        Args:
            stamp: Its stamp [ns].
            values: Mean squares of innovations, then of disturbance torques, over those of noise [1], shape (2 M,).
        """
        before = self.levels(stamp)
        self._windows += 1
        self._sums += values
        for row, length in enumerate(LENGTHS):
            if self._windows % length:
                continue
            mean = self._sums[row] / length
            self._sums[row] = 0.0
            self._shares[row] = np.maximum(mean - 1, 0.0) / (self._thresholds.alarm[row] - 1)
            begun = stamp - (length - 1) * round(WINDOW * 1e9)
            self._note(Level.WARNING, mean > self._thresholds.warning[row], begun, stamp)
            self._note(Level.ALARM, mean > self._thresholds.alarm[row], begun, stamp)
        after = self.levels(stamp)
        self.raised += int(after.max() == Level.ALARM > before.max())
        self.warned += int(after.max() >= Level.WARNING > before.max())

    def diverged(self, stamp: int) -> None:
        """Raise an alarm of all motors because the observer diverged."""
        before = self.levels(stamp)
        for level in (Level.WARNING, Level.ALARM):
            self._note(level, np.ones(self._shares.shape[1], dtype=bool), stamp, stamp)
        self.raised += int(before.max() < Level.ALARM)
        self.warned += int(before.max() < Level.WARNING)

    def levels(self, stamp: int) -> FloatArray:
        """Return the level of every motor, shape (M,)."""
        held = (self._last >= 0) & (stamp - self._last <= HOLD * 1e9)
        return np.where(held[Level.ALARM], int(Level.ALARM), np.where(held[Level.WARNING], int(Level.WARNING), 0))

    def states(self, stamp: int) -> tuple[MotorAlarm, ...]:
        """Return the state of every motor."""
        motors = self._begun.shape[1]
        shares = self._shares.max(axis=0)
        return tuple(
            MotorAlarm(
                Level(int(level)),
                int(self._begun[int(level), motor]) if level else -1,
                float(max(shares[motor], shares[motors + motor])),
            )
            for motor, level in enumerate(self.levels(stamp).tolist())
        )

    def _note(self, level: Level, beyond: FloatArray, begun: int, stamp: int) -> None:
        """Record the motors with a signal beyond a threshold."""
        motors = beyond.reshape(2, -1).any(axis=0)
        new = motors & ((self._last[level] < 0) | (stamp - self._last[level] > HOLD * 1e9))
        self._begun[level] = np.where(new, begun, self._begun[level])
        self._last[level] = np.where(motors, stamp, self._last[level])
