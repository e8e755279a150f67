"""Threads of BLAS, which wait for each other where computations run side by side already."""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING

from threadpoolctl import threadpool_limits

if TYPE_CHECKING:
    from collections.abc import Iterator


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Let every call of BLAS in this process use one thread while in the block, or in a function that it decorates."""
    with threadpool_limits(limits=1, user_api="blas"):
        yield
