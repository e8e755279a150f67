"""When a message of a replay is due: rate and pause. The clock is given, not fetched."""

from __future__ import annotations

import math

from flexros.logs.stamps import NANOSECONDS


class ReplayPace:
    """Ties log time to the seconds of one monotonic clock.

    Args:
        rate: Seconds of the log for each second of the clock; infinite for as fast as possible.
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
        """Return the clock's time at which a log time is due [s]; infinite in a pause."""
        if self.paused:
            return math.inf
        return self._now + (log_time - self._log_time) / (self._rate * NANOSECONDS)

    def pause(self, now: float) -> None:
        """Stand still from now on [s]."""
        if not self.paused:
            self._anchor(now)
            self.paused = True

    def resume(self, now: float) -> None:
        """Go on from where the pause began, now [s]."""
        if self.paused:
            self._now, self.paused = now, False

    def change_rate(self, rate: float, now: float) -> None:
        """Go on at another rate from now [s]."""
        if not self.paused:
            self._anchor(now)
        self._rate = rate

    def _anchor(self, now: float) -> None:
        if now > self._now and math.isfinite(self._rate):
            self._log_time += (now - self._now) * self._rate * NANOSECONDS
            self._now = now
