"""Execution of the parts of a long computation, on a Dask cluster of the user or in this process."""

from __future__ import annotations

import gc
import os
from contextlib import contextmanager
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from flexros.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from distributed import Client, Future

ANSWER = 10.0
"""Timeout for the answer of a scheduler [s]."""


LOCAL = "127.0.0.1:0"
"""Address of the dashboard of local workers: this machine only, any free port."""


@contextmanager
def connected(address: str = "", threads: int | None = None) -> Iterator[Client]:
    """Provide a Dask client within a context.

    Args:
        address: Address of a scheduler, e.g. "tcp://127.0.0.1:8786"; empty for worker threads of this process that
            accept no outside connections.
        threads: Number of such threads; default: one per processor.

    Yields:
        The client.

    Raises:
        InputError: No scheduler answers at the address.
    """
    import dask
    from distributed import Client  # here, because it loads slowly

    if address:
        with _client_of(address) as client:
            yield client
        return
    quiet = {
        "distributed.worker.memory.terminate": False,
        "distributed.admin.tick.limit": "1h",
        # the worker is a part of this process: it is not lost where the machine sleeps, and no other takes its work
        "distributed.scheduler.worker-ttl": None,
    }
    with (
        TemporaryDirectory(prefix="flexros_") as scratch,
        dask.config.set(quiet),
        Client(
            processes=False,
            n_workers=1,
            threads_per_worker=threads or os.cpu_count(),
            memory_limit=0,
            dashboard_address=LOCAL,
            worker_dashboard_address=LOCAL,
            local_directory=scratch,
            protocol="inproc",
            set_as_default=False,  # other users of Dask in this process keep theirs
        ) as client,
    ):
        yield client


def _client_of(address: str) -> Client:
    from distributed import Client  # here, because it loads slowly

    try:
        return Client(address, timeout=ANSWER, set_as_default=False)
    except (OSError, ValueError) as error:
        refusal = str(error)
    # A client that failed closes itself when it is collected, and for that takes the lock under which the next client
    # starts its thread. If that thread is the one to collect it, both wait for each other until Dask gives up. So it is
    # collected here, outside of the handler, because the error holds the client.
    gc.collect()
    raise InputError(
        f"no Dask scheduler answers at '{address}' ({refusal}); start one (dask scheduler), or give no address",
        "scheduler",
    )


def finished(client: Client, submitted: Iterable[Future]) -> Iterator[Future]:
    """Yield submitted jobs as they finish; on an error or interruption the others are cancelled.

    Args:
        client: The client.
        submitted: Jobs.

    Yields:
        Each finished job, whose result is released afterwards.

    Raises:
        Exception: The error of a job.
    """
    from distributed import as_completed  # here, because it loads slowly

    waiting = list(submitted)
    try:
        for job in as_completed(waiting, loop=client.loop):
            job.result()
            yield job
            job.release()
    except BaseException:
        client.cancel(waiting)
        raise
