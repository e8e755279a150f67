"""A bound on the load of an observer: it works for a while, and passes over what it has no time for."""

from __future__ import annotations

REST = 10.0
"""Time over which the load is spread [s] (chosen): what is watched hangs together for as long."""


class LoadBudget:
    """Processor time that may be used, saved up while nothing is done.

    Args:
        share: Share of one processor that may be used [1].
    """

    def __init__(self, share: float) -> None:
        self._share = share
        self._saved = share * REST
        self._last: float | None = None
        self._open = True

    def allows(self, now: float) -> bool:
        """Tell whether there is time left; once there was none, not before half of it has been saved up again.

        Args:
            now: Time of a clock that runs evenly [s].
        """
        if self._last is not None:
            self._saved = min(self._saved + self._share * (now - self._last), self._share * REST)
        self._last = now
        self._open = self._saved > (0.0 if self._open else self._share * REST / 2)
        return self._open

    def use(self, time: float) -> None:
        """Take off processor time that was used [s]."""
        self._saved -= time
