"""Progress of a diagnosis, and the time of its stages."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

STEP = 0.2
"""Share of what is left of a stage that each of its steps counts for [1] (chosen): a search has four to eight."""


class Stages:
    """Reports progress, and keeps the time of every stage.

    Args:
        progress: Called with the name of the stage and the share of all that is done.
    """

    def __init__(self, progress: Callable[[str, float], None] | None) -> None:
        self.timings: dict[str, float] = {}
        self._progress = progress
        self._name, self._from, self._to, self._begin = "", 0.0, 0.0, time.monotonic()
        self._step, self._done, self._span = "", 0.0, 1.0
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
        self._step, self._done, self._span = name, 0.0, STEP
        self.inner(name, 0.0)

    def inner(self, name: str, share: float) -> None:
        """Report the share of a step of the current stage; each takes `STEP` of what is left."""
        if name != self._step:
            self._step, self._done = name, self._done + self._span
            self._span = STEP * (1.0 - self._done)
        self._told = self._from + (self._done + share * self._span) * (self._to - self._from)
        if self._progress is not None:
            self._progress(name, self._told)

    def end(self) -> None:
        """End the current stage."""
        if self._name:
            self.timings[self._name] = self.timings.get(self._name, 0.0) + time.monotonic() - self._begin
            self._name = ""
