"""Ctrl-C and termination as a flag that the loop sees, so that logs close and nodes end in order."""

from __future__ import annotations

import signal
import threading
from contextlib import contextmanager
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from collections.abc import Iterator
    from types import FrameType

SIGNALS = (signal.SIGINT, signal.SIGTERM)


class Result(Protocol):
    """What an interruption completes; rclpy's Future is one."""

    def set_result(self, result: object) -> None:
        """Complete it."""


class Interruption:
    """Remembers that the user, or the system, wants an end."""

    def __init__(self) -> None:
        self._came = False
        self._ends: list[Result] = []

    def ends(self, result: Result) -> None:
        """Complete a result when a signal comes: an executor that is never idle looks at nothing else."""
        self._ends.append(result)
        if self._came:
            result.set_result(None)

    def __call__(self) -> bool:
        """Tell whether a signal has come."""
        return self._came

    def note(self, number: int, frame: FrameType | None) -> None:
        """Take a signal."""
        self._came = True
        for result in self._ends:
            result.set_result(None)


@contextmanager
def interruption() -> Iterator[Interruption]:
    """Catch SIGINT and SIGTERM while in the block; outside the main thread Python leaves them to others."""
    noted = Interruption()
    if threading.current_thread() is not threading.main_thread():
        yield noted
        return
    before = {number: signal.signal(number, noted.note) for number in SIGNALS}
    try:
        yield noted
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
