"""Bound on the processor load of the monitor: messages beyond its time budget are skipped."""

from __future__ import annotations

REST = 10.0
"""Time over which the load is averaged [s] (chosen): monitored stretches are contiguous for as long."""


class LoadBudget:
    """Budget of processor time, which accumulates while idle.

    Args:
        share: Share of one processor that may be used [1].
    """

    def __init__(self, share: float) -> None:
        self._share = share
        self._saved = share * REST
        self._last: float | None = None
        self._open = True

    def allows(self, now: float) -> bool:
        """Return whether time is left; once exhausted, half of the budget must accumulate first.

        Args:
            now: Time of a monotonic clock [s].
        """
        if self._last is not None:
            self._saved = min(self._saved + self._share * (now - self._last), self._share * REST)
        self._last = now
        self._open = self._saved > (0.0 if self._open else self._share * REST / 2)
        return self._open

    def use(self, time: float) -> None:
        """Subtract processor time that was used [s]."""
        self._saved -= time
