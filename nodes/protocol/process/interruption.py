"""Signals as flags that the loop polls, so that logs are closed and nodes shut down in order."""

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
"""Signal by which the parent process informs a node that a partner has exited."""


class Interruption:
    """Flag of a request to terminate, by the user or the system.

    The signal handler only sets a flag: it may run at any point, also while the interrupted code holds a lock. Waiting
    code polls the flag.

    Attributes:
        partner_ended: Whether a partner of the node has exited.
        parent_died: Whether the parent process has died; set by the code that watches it.
    """

    def __init__(self) -> None:
        self._requested = False
        self.partner_ended = False
        self.parent_died = False

    def __call__(self) -> bool:
        """Return whether termination was requested."""
        return self._requested

    def note(self, number: int, frame: FrameType | None) -> None:
        """Handle a signal."""
        if number == PARTNER_ENDED:
            self.partner_ended = True
        else:
            self._requested = True


@contextmanager
def interruption() -> Iterator[Interruption]:
    """Catch SIGINT, SIGTERM and PARTNER_ENDED within the block; only the main thread can install handlers."""
    interrupted = Interruption()
    if threading.current_thread() is not threading.main_thread():
        yield interrupted
        return
    before = {number: signal.signal(number, interrupted.note) for number in (*SIGNALS, PARTNER_ENDED)}
    try:
        yield interrupted
    finally:
        for number, handler in before.items():
            signal.signal(number, signal.SIG_DFL if handler is None else handler)
