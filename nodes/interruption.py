"""Ctrl-C and termination as a flag that the loop sees, so that logs close and nodes end in order."""

from __future__ import annotations

import signal
import threading
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator
    from types import FrameType

SIGNALS = (signal.SIGINT, signal.SIGTERM)


class Interruption:
    """Remembers that the user, or the system, wants an end."""

    def __init__(self) -> None:
        self._came = False

    def __call__(self) -> bool:
        """Tell whether a signal has come."""
        return self._came

    def note(self, number: int, frame: FrameType | None) -> None:
        """Take a signal."""
        self._came = True


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
