"""Progress of a computation with the time left: a bar on a terminal, else plain lines now and then."""

from __future__ import annotations

import sys
import threading
import time
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TaskProgressColumn, TextColumn, TimeElapsedColumn
from rich.progress import TimeRemainingColumn as TimeLeftColumn

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

EVERY = 10.0
"""Time between two lines of a stage [s]."""
QUIET = 2.0
"""Time for which work is not spoken of where there is no terminal [s]."""
_BEAT = 0.5
"""Time between two looks whether a line is due [s] (chosen)."""
_KNOWN = 0.02
"""Share that must be done before the time left is estimated [1] (chosen)."""
_RISE = 0.02
"""Rise of the share below which hardly more is done [1] (chosen)."""
_LONG = 30.0
"""Time after which any share that is done will do for it [s] (chosen)."""


def progress_bar(shown: bool = True) -> ProgressBar:
    """Make a transient progress bar on stderr; where that is no terminal, lines from 2 s on.

    Args:
        shown: False for a step of work that has a bar already.

    Returns:
        The bar.
    """
    return ProgressBar(shown)


class ProgressBar(Progress):
    """A bar with elapsed and remaining time on a terminal, else lines on stderr.

    Args:
        shown: Whether anything is shown.
        clock: Returns the time [s].
    """

    def __init__(self, shown: bool = True, clock: Callable[[], float] = time.monotonic) -> None:
        stderr = Console(stderr=True)
        columns = (
            TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeElapsedColumn(),
            TextColumn("left"), TimeLeftColumn(),
        )  # fmt: skip
        hidden = not (shown and stderr.is_terminal)
        super().__init__(*columns, console=stderr, transient=True, disable=hidden, refresh_per_second=4)
        self._said: dict[TaskID, tuple[float, float]] = {}
        self._lines, self._clock = shown and not stderr.is_terminal, clock
        self._saying, self._over = threading.Lock(), threading.Event()

    def start(self) -> None:
        """Begin to show, as in rich; without a terminal also work that does not report is spoken of."""
        super().start()
        if self._lines and self._clock is time.monotonic:
            self._over.clear()
            threading.Thread(target=self._beat, daemon=True).start()

    def stop(self) -> None:
        """End to show, as in rich."""
        self._over.set()
        super().stop()

    def _beat(self) -> None:
        while not self._over.wait(_BEAT):
            for task in self.tasks:
                if not task.finished:
                    self._say(task.id)

    def add_task(self, *args: Any, **fields: Any) -> TaskID:
        """Add a task, as in rich; its time begins."""
        task = super().add_task(*args, **fields)
        self._said[task] = (self._clock(), self._clock() + QUIET - EVERY)
        return task

    def update(self, task_id: TaskID, **fields: Any) -> None:
        """Update a task, as in rich."""
        super().update(task_id, **fields)
        self._say(task_id)

    def advance(self, task_id: TaskID, advance: float = 1) -> None:
        """Advance a task, as in rich."""
        super().advance(task_id, advance)
        self._say(task_id)

    def _say(self, task_id: TaskID) -> None:
        """Print a line where one is due."""
        with self._saying:
            begin, last = self._said.get(task_id, (0.0, float("inf")))
            now = self._clock()
            if not self._lines or now - last < EVERY:
                return
            self._said[task_id] = (begin, now)
            task = self._tasks[task_id]
            share = task.completed / task.total if task.total else None
            _tell(line(now - begin, task.description, share))


def line(elapsed: float, stage: str, share: float | None, standing: float = 0.0) -> str:
    """Write a line of progress.

    Args:
        elapsed: Time since the beginning [s].
        stage: What is done.
        share: Share of all that is done [1]; None where not known.
        standing: Time for which hardly more is done [s].
    """
    done = "" if share is None else f", {100 * share:.0f} % done"
    left = None if share is None else time_left(elapsed, share, standing)
    rest = ", time left not known" if elapsed >= QUIET and (share is None or share < 1.0) else ""
    if left is not None:
        rest = f", about {left:.0f} s left" if left < 100 else f", about {left / 60:.0f} min left"
    return f"flexros: {elapsed:.0f} s: {stage}{done}{rest}"


def time_left(elapsed: float, share: float, standing: float = 0.0) -> float | None:
    """Estimate the time left at the pace so far [s]; None at the begin and at the end.

    Steps of unknown number may go on for a long time at the same share: for as long as they have, at least.
    """
    enough = share >= _KNOWN or (elapsed >= _LONG and share > 0.0)
    if elapsed < QUIET or not enough or share >= 1.0:
        return None
    return max(elapsed * (1.0 - share) / share, standing)


@contextmanager
def progress_shown() -> Iterator[Callable[[str, float], None]]:
    """Show progress on stderr: as a bar on a terminal, else a line when a stage begins and at most every 10 s.

    Yields:
        What is called with the name of the stage and the share of all that is done [1].
    """
    with progress_bar() as bar:
        yield Lines() if bar.disable else _on(bar)


@contextmanager
def working(what: str) -> Iterator[None]:
    """Show that something is being done whose progress is not known.

    Args:
        what: What is done.
    """
    with progress_bar() as bar:
        bar.add_task(what, total=None)
        yield


class Lines:
    """Prints progress as lines.

    Args:
        clock: Returns the time [s].
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock, self._begin, self._last = clock, clock(), -EVERY
        self._stages: set[str] = set()
        self._done = 0.0
        self._rise = (0.0, 0.0)

    def __call__(self, stage: str, share: float) -> None:
        """Print a line, for a new stage at once; the share never falls where a step is done again."""
        self._done = max(self._done, share)
        now = self._clock() - self._begin
        if self._done > self._rise[0] + _RISE:
            self._rise = (self._done, now)
        if stage in self._stages and now - self._last < EVERY:
            return
        self._stages.add(stage)
        self._last = now
        _tell(line(now, stage, self._done, now - self._rise[1]))


def _tell(text: str) -> None:
    """Write a line to stderr at once: whoever reads along gets no half of it."""
    sys.stderr.write(f"{text}\n")
    sys.stderr.flush()


def _on(bar: Progress) -> Callable[[str, float], None]:
    """Show stage and share; a stage starts its remaining time anew where the number of its steps was unknown."""
    task = bar.add_task("", total=1.0)

    def show(stage: str, share: float) -> None:
        if share < bar.tasks[0].completed:
            bar.reset(task)
        bar.update(task, description=stage, completed=share)

    return show
