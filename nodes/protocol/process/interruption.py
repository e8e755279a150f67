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
PARTNER_ENDED = signal.SIGUSR1
"""By which whoever started a node tells it that a partner has died."""


class Interruption:
    """Remembers that the user, or the system, wants an end.

    The handler of the signal only sets a flag: it may run in the midst of anything, also while the interrupted code
    holds a lock. Whoever waits looks at the flag now and then.

    Attributes:
        partner_ended: Whether a partner of the node has died.
        parent_died: Whether the process that started the node has died; set by who looks for it.
    """

    def __init__(self) -> None:
        self._came = False
        self.partner_ended = False
        self.parent_died = False

    def __call__(self) -> bool:
        """Tell whether a signal has come."""
        return self._came

    def note(self, number: int, frame: FrameType | None) -> None:
        """Take a signal."""
        if number == PARTNER_ENDED:
            self.partner_ended = True
        else:
            self._came = True


@contextmanager
def interruption() -> Iterator[Interruption]:
    """Catch SIGINT, SIGTERM and news of partners in the block; outside the main thread Python leaves them to others."""
    noted = Interruption()
    if threading.current_thread() is not threading.main_thread():
        yield noted
        return
    before = {number: signal.signal(number, noted.note) for number in (*SIGNALS, PARTNER_ENDED)}
    try:
        yield noted
    finally:
        for number, handler in before.items():
            signal.signal(number, signal.SIG_DFL if handler is None else handler)
