"""The end of a search: when its time is over, or when someone interrupts it."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Literal

from flexros.gap.schema import Partial

if TYPE_CHECKING:
    from collections.abc import Callable

FINISHING, LEAST_FINISHING = 0.15, 2.0
"""Time to finish the best explanation in, over the time used until then [1], and at least this long [s]."""


class Deadline:
    """Tells the steps of a search when to stop, and remembers the first one that was cut short.

    Once the time is over, nothing new is begun and what runs ends at its next iteration. The best explanation so far is
    then finished, for which there is a little time as well.

    Args:
        limit: Time from now on [s]; None for no limit.
        interrupted: Asked between fits; True from the moment on at which the search must end.
        kept: Share of the limit that is kept for the steps after the search, until `release` [1].
        clock: Returns the time [s].
    """

    def __init__(
        self,
        limit: float | None = None,
        interrupted: Callable[[], bool] | None = None,
        kept: float = 0.0,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.step = ""
        self._limit, self._interrupted, self._kept, self._clock = limit, interrupted, kept, clock
        self._begin, self._abandoned = clock(), False
        self._ended: tuple[float, bool] | None = None  # time used [s] and whether it ran out: threads set both at once
        self._cut: tuple[str, float, bool] | None = None  # the step that was cut short first, and the same
        self._left_out: list[str] = []

    @property
    def over(self) -> bool:
        """Whether the time is over, or the search was interrupted."""
        if self._ended is None:
            used = self._clock() - self._begin
            by_time = self._limit is not None and used >= self._limit * (1 - self._kept)
            if by_time or (self._interrupted is not None and self._interrupted()):
                self._ended = self._ended or (used, by_time)
        return self._ended is not None

    @property
    def spent(self) -> bool:
        """Whether the time to finish the best explanation is over as well."""
        if not self.over or self._ended is None:
            return False
        used, by_time = self._ended
        ended = self._limit * (1 - self._kept) if by_time and self._limit is not None else used
        allowed = ended + max(FINISHING * ended, LEAST_FINISHING)
        return self._abandoned or self._clock() - self._begin > allowed

    def begin(self, step: str) -> None:
        """Name the step that begins."""
        self.step = step

    def release(self) -> None:
        """Let the steps after the search begin, in the time that was kept for them."""
        if self._kept and self._ended is not None and self._ended[1]:
            self._ended = None
        self._kept = 0.0

    def stops(self) -> bool:
        """Return whether a step must be left out, which is noted, as the time is over."""
        return self._noted(self.over)

    def stops_finishing(self) -> bool:
        """Return whether a step that finishes the best explanation must be left out, which is noted."""
        return self._noted(self.spent)

    def leaves_out(self, part: str) -> bool:
        """Return whether a part of the answer must be left out, which is noted, as nothing may begin any more.

        Args:
            part: The part, in the words of the answer.
        """
        if self.stops_finishing() and part not in self._left_out:
            self._left_out.append(part)
        return part in self._left_out

    def of_fit(self, *, finishing: bool = False) -> Callable[[], bool]:
        """Return what a fit that begins now asks after each iteration: whether it must end.

        Args:
            finishing: Whether it finishes an explanation; every fit does that begins when the time is over.
        """
        return self.stops_finishing if finishing or self.over else self.stops

    def abandon(self) -> None:
        """End all fits at their next iteration, as nobody waits for them any more."""
        self._abandoned = True
        self._ended = self._ended or (self._clock() - self._begin, False)

    @property
    def partial(self) -> Partial | None:
        """What was cut short; None where nothing was."""
        if self._cut is None:
            return None
        step, used, by_time = self._cut
        reason: Literal["time_limit", "interrupted"] = "time_limit" if by_time else "interrupted"
        return Partial(reason=reason, after=used, step=step, left_out=tuple(self._left_out))

    def _noted(self, left_out: bool) -> bool:
        if left_out and self._cut is None and self._ended is not None:
            self._cut = (self.step, *self._ended)
        return left_out
