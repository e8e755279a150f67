"""Due time of the messages of a replay, with rate and pause; the caller passes the clock's time."""

from __future__ import annotations

import math

from flexros.logs.stamps import NANOSECONDS


class ReplayPace:
    """Map from log time to the time of a monotonic clock.

    Args:
        rate: Seconds of the log per second of the clock; infinite for as fast as possible.
    """

    def __init__(self, rate: float = 1.0) -> None:
        self._rate = rate
        self._now = 0.0
        self._log_time = 0.0
        self.paused = False

    def begin(self, now: float, log_time: int) -> None:
        """Set the clock's time [s] at which a log time [ns] is due."""
        self._now, self._log_time = now, float(log_time)

    def due(self, log_time: int) -> float:
        """Return the clock's time at which a log time is due [s]; infinite during a pause."""
        if self.paused:
            return math.inf
        return self._now + (log_time - self._log_time) / (self._rate * NANOSECONDS)

    def pause(self, now: float) -> None:
        """Pause from `now` on [s]."""
        if not self.paused:
            self._anchor(now)
            self.paused = True

    def resume(self, now: float) -> None:
        """Continue at `now` [s] from where the pause began."""
        if self.paused:
            self._now, self.paused = now, False

    def change_rate(self, rate: float, now: float) -> None:
        """Continue at another rate from `now` on [s]."""
        if not self.paused:
            self._anchor(now)
        self._rate = rate

    def _anchor(self, now: float) -> None:
        if now > self._now and math.isfinite(self._rate):
            self._log_time += (now - self._now) * self._rate * NANOSECONDS
            self._now = now
