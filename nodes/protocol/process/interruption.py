"""Signals as flags that the loop polls, so that logs are closed and nodes shut down in order."""

from __future__ import annotations

import signal
import threading
from contextlib import contextmanager, nullcontext
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator
    from contextlib import AbstractContextManager
    from types import FrameType

SIGNALS = (signal.SIGINT, signal.SIGTERM)
PARTNER_ENDED = signal.SIGUSR1
"""Signal by which the parent process informs a node that a partner has exited."""
REMINDER = signal.SIGVTALRM
"""Signal by which a request that foreign code has swallowed is repeated."""
REMINDED = 1.0
"""Processor time after which it is [s], chosen: what ends in order is out of the block by then."""


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
        self._raises = 0
        self.partner_ended = False
        self.parent_died = False

    def __call__(self) -> bool:
        """Return whether termination was requested."""
        return self._requested

    def note(self, number: int, frame: FrameType | None) -> None:
        """Handle a signal."""
        if number == PARTNER_ENDED:
            self.partner_ended = True
            return
        self._requested = self._requested or number != REMINDER
        if self._requested and self._raises:
            signal.setitimer(signal.ITIMER_VIRTUAL, REMINDED)
            raise KeyboardInterrupt

    @contextmanager
    def raising(self) -> Iterator[None]:
        """Let a request to terminate raise KeyboardInterrupt within the block, also one that was made before.

        Foreign code that runs the handler may swallow the exception, as CasADi does, and return nothing or go on: what
        fails then fails because of the request, and what goes on is reminded of it.
        """
        self._raises += 1
        try:
            if self._requested:
                raise KeyboardInterrupt
            yield
        except Exception:
            if self._requested:
                raise KeyboardInterrupt from None
            raise
        finally:
            self._raises -= 1
        if self._requested:
            raise KeyboardInterrupt

    @contextmanager
    def waiting(self) -> Iterator[None]:
        """Within `raising`, let a request to terminate wait for the end of the block."""
        raises, self._raises = self._raises, 0
        try:
            yield
        finally:
            self._raises = raises
        if raises and self._requested:
            raise KeyboardInterrupt


_present: Interruption | None = None


def interruptible() -> AbstractContextManager[None]:
    """Let SIGINT and SIGTERM end the block at once, where `interruption` catches them.

    For work of seconds that polls no flag and has nothing to lose: the preparation of a run.
    """
    return nullcontext() if _present is None else _present.raising()


@contextmanager
def uninterruptible() -> Iterator[None]:
    """Within `interruptible`, let SIGINT and SIGTERM wait for the end of the block.

    For short foreign code that must not be left half done: rclpy cannot destroy a subscription whose events it has not
    registered yet.
    """
    with nullcontext() if _present is None else _present.waiting():
        yield


@contextmanager
def interruption() -> Iterator[Interruption]:
    """Catch SIGINT, SIGTERM and PARTNER_ENDED within the block; only the main thread can install handlers."""
    interrupted = Interruption()
    if threading.current_thread() is not threading.main_thread():
        yield interrupted
        return
    global _present
    outer, _present = _present, interrupted
    before = {number: signal.signal(number, interrupted.note) for number in (*SIGNALS, PARTNER_ENDED, REMINDER)}
    try:
        yield interrupted
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
        _present = outer
        for number, handler in before.items():
            signal.signal(number, signal.SIG_DFL if handler is None else handler)
