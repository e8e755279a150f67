"""Control of BLAS threads, which block each other when computations already run in parallel."""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING

from threadpoolctl import threadpool_limits

if TYPE_CHECKING:
    from collections.abc import Iterator


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Limit BLAS in this process to one thread, as a context manager or decorator."""
    with threadpool_limits(limits=1, user_api="blas"):
        yield
