"""Wake-up of waiting threads when the system clock is set.

C++ libraries built for a glibc before 2.30, as those of the wheels, wait on condition variables until a time of the
system clock. If the clock is set back by an hour meanwhile, a wait of half a millisecond lasts for an hour.
"""

from __future__ import annotations

import ctypes
import os
import select
import threading
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

_CLOCK_REALTIME = 0
_ABSOLUTE, _CANCEL_ON_SET = 1, 2
_NEVER = 1 << 33
"""Time of the system clock in the year 2242 [s]."""


class _Time(ctypes.Structure):
    _fields_ = (
        ("interval_s", ctypes.c_long),
        ("interval_ns", ctypes.c_long),
        ("first_s", ctypes.c_long),
        ("first_ns", ctypes.c_long),
    )


@contextmanager
def waking_at_clock_steps(wake: Callable[[], object]) -> Iterator[bool]:
    """Call `wake` whenever the system clock is set within the block.

    The kernel cancels a timer of the system clock when the clock is set (timerfd_create(2), TFD_TIMER_CANCEL_ON_SET).

    Args:
        wake: Called in a thread of its own, so it must be thread-safe.

    Yields:
        Whether the system reports clock steps.
    """
    timer = clock_timer()
    if timer is None:
        yield False
        return
    end, ended = os.pipe()
    thread = threading.Thread(target=_watch, args=(timer, end, wake), name="clock steps", daemon=True)
    thread.start()
    try:
        yield True
    finally:
        os.close(ended)
        thread.join()
        os.close(end)
        os.close(timer)


def clock_timer() -> int | None:
    """Open a timer of the system clock; None where the system has none."""
    try:
        timer = ctypes.CDLL(None).timerfd_create(_CLOCK_REALTIME, os.O_CLOEXEC | os.O_NONBLOCK)
    except (AttributeError, OSError):
        return None
    if timer < 0:
        return None
    if _arm(timer):
        return int(timer)
    os.close(timer)
    return None


def _arm(timer: int) -> bool:
    """Arm a timer for the next step of the clock."""
    time = _Time(0, 0, _NEVER, 0)
    result = ctypes.CDLL(None).timerfd_settime(timer, _ABSOLUTE | _CANCEL_ON_SET, ctypes.byref(time), None)
    return bool(result == 0)


def _watch(timer: int, end: int, wake: Callable[[], object]) -> None:
    """Wait for clock steps until the other end of the pipe is closed."""
    events = select.poll()
    events.register(timer, select.POLLIN)
    events.register(end, select.POLLIN)
    while not any(descriptor == end for descriptor, _ in events.poll()):
        with suppress(OSError):  # ECANCELED: the clock was set
            os.read(timer, 8)
        _arm(timer)
        wake()
