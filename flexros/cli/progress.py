"""Progress of a computation by stages: a bar on a terminal, else plain lines."""

from __future__ import annotations

import sys
import time
from contextlib import contextmanager
from typing import TYPE_CHECKING

from flexros.cli.output import progress_bar

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from rich.progress import Progress

EVERY = 10.0
"""Time between two lines of a stage [s]."""


@contextmanager
def progress_shown() -> Iterator[Callable[[str, float], None]]:
    """Show progress on stderr: as a bar on a terminal, else a line when a stage begins and at most every 10 s.

    Yields:
        What is called with the name of the stage and the share of all that is done [1].
    """
    with progress_bar() as bar:
        yield Lines() if bar.disable else _on(bar)


class Lines:
    """Prints progress as lines.

    Args:
        clock: Returns the time [s].
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock, self._begin, self._last = clock, clock(), -EVERY
        self._stages: set[str] = set()
        self._done = 0.0

    def __call__(self, stage: str, share: float) -> None:
        """Print a line, for a new stage at once; the share never falls where a step is done again."""
        self._done = max(self._done, share)
        now = self._clock() - self._begin
        if stage in self._stages and now - self._last < EVERY:
            return
        self._stages.add(stage)
        self._last = now
        print(f"flexros: {now:.0f} s: {stage}, {100 * self._done:.0f} % done", file=sys.stderr, flush=True)


def _on(bar: Progress) -> Callable[[str, float], None]:
    """Show stage and share; a stage starts its remaining time anew where the number of its steps was unknown."""
    task = bar.add_task("", total=1.0)

    def show(stage: str, share: float) -> None:
        if share < bar.tasks[0].completed:
            bar.reset(task)
        bar.update(task, description=stage, completed=share)

    return show
