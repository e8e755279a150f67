"""Ctrl-C that ends a long computation with what is known so far."""

from __future__ import annotations

import os
import signal
import threading
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

STDERR = 2


@contextmanager
def interruptible(notice: str) -> Iterator[Callable[[], bool]]:
    """Let the first Ctrl-C inside ask for the end of the work; the second one ends the command, as any outside does.

    Args:
        notice: What happens now, printed after the first one.

    Yields:
        Whether the end was asked for.
    """
    asked = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield asked.is_set  # signals are handled by the main thread alone
        return
    before = signal.getsignal(signal.SIGINT)

    def first(_number: int, _frame: object) -> None:
        asked.set()
        signal.signal(signal.SIGINT, before)
        os.write(STDERR, f"\nflexros: interrupted by Ctrl-C: {notice}\n".encode())  # print may be interrupted itself

    signal.signal(signal.SIGINT, first)
    try:
        yield asked.is_set
    finally:
        signal.signal(signal.SIGINT, before)
