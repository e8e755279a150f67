"""Progress of a diagnosis, and the time of its stages."""

from __future__ import annotations

import time
from itertools import count
from types import MappingProxyType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

BEGINS: Mapping[str, float] = MappingProxyType(
    {
        "candidates": 0.02,
        "single effects": 0.03,
        "best effects": 0.05,
        "effects left out": 0.08,
        "effects together": 0.13,
        "effects exchanged": 0.15,
        "richer effects": 0.3,
        "simpler effects": 0.44,
        "other scales": 0.5,
        "effects divided": 0.5,
        "effects regrouped": 0.52,
        "effects in place": 0.54,
        "sizes nearby": 0.65,
        "common scale": 0.67,
        "effects on held-out data": 0.96,
    }
)
"""Share of the time of a search that had passed when a step first began [1]: about the medians in diagnoses of
measured robots; in none of them other scales were tried or effects divided (chosen)."""


class Stages:
    """Reports progress, and keeps the time of every stage.

    How many steps a search has, and how often it comes back to one, shows at its end. So a step stands where it usually
    begins for the first time, and the share that was told never falls.

    Args:
        progress: Called with the name of the stage and the share of all that is done.
    """

    def __init__(self, progress: Callable[[str, float], None] | None) -> None:
        self.timings: dict[str, float] = {}
        self._progress = progress
        self._name, self._from, self._to, self._begin = "", 0.0, 0.0, time.monotonic()
        self._before = self._told = 0.0

    def again(self) -> None:
        """Go through the stages once more: their shares are from now on of what is left, and their times add up."""
        self.end()
        self._before = self._to = self._told

    def begin(self, name: str, share: float) -> None:
        """Begin a stage that ends when `share` of all is done."""
        self.end()
        to = self._before + share * (1.0 - self._before)
        self._name, self._from, self._to, self._begin = name, self._to, to, time.monotonic()
        self.inner(name, 0.0)

    def inner(self, name: str, share: float) -> None:
        """Report the share of a step of the current stage: one of the search, or all that the stage does."""
        begin, end = 0.0, 1.0
        if name in BEGINS:
            begin = BEGINS[name]
            end = min((later for later in BEGINS.values() if later > begin), default=1.0)
        done = self._from + (begin + share * (end - begin)) * (self._to - self._from)
        self._told = max(self._told, done)
        if self._progress is not None:
            self._progress(name, self._told)

    def of_fit(self, most: int, stop: Callable[[], bool]) -> Callable[[], bool]:
        """Return what a fit asks after each iteration, whether it must end; the share of its iterations is reported.

        Args:
            most: Most iterations.
            stop: Whether it must end.
        """
        done = count(1)

        def asked() -> bool:
            self.inner(self._name, min(next(done) / most, 1.0))
            return stop()

        return asked

    def end(self) -> None:
        """End the current stage."""
        if self._name:
            self.timings[self._name] = self.timings.get(self._name, 0.0) + time.monotonic() - self._begin
            self._name = ""
