"""Workers within this process, or those of a scheduler that the user has."""

from __future__ import annotations

import gc
import os

import dask
import psutil  # type: ignore[import-untyped]
import pytest
from distributed import Client, LocalCluster

from flexros.errors import InputError
from flexros.scheduler import LOCAL, connected

pytestmark = pytest.mark.slow


def test_work_runs_in_this_process_by_default() -> None:
    with connected(threads=1) as client:
        assert client.submit(os.getpid).result() == os.getpid()
        assert not client.scheduler_info()["address"].startswith("tcp")


def test_work_runs_on_a_scheduler_that_is_named() -> None:
    with (
        LocalCluster(
            n_workers=1,
            threads_per_worker=1,
            processes=False,
            protocol="tcp",
            host="127.0.0.1",
            dashboard_address=LOCAL,
        ) as cluster,
        connected(cluster.scheduler_address) as client,
    ):
        assert client.scheduler_info()["address"] == cluster.scheduler_address
        assert client.submit(sum, [1, 2]).result() == 3


@pytest.mark.parametrize("address", ["nonsense://1", "tcp://127.0.0.1:1"])
def test_missing_scheduler_is_reported(address: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("flexros.scheduler.ANSWER", 0.5)
    message = f"no Dask scheduler answers at '{address}'"
    with pytest.raises(InputError, match=message), connected(address):
        pytest.fail("nobody answers there")


def test_a_client_that_failed_is_gone(monkeypatch: pytest.MonkeyPatch) -> None:
    """It closes itself when it is collected; in the thread that the next client starts, both wait for each other."""
    monkeypatch.setattr("flexros.scheduler.ANSWER", 0.5)
    gc.disable()
    try:
        with pytest.raises(InputError), connected("nonsense://1"):
            pytest.fail("nobody answers there")
        assert not any(isinstance(one, Client) and one.status != "closed" for one in gc.get_objects())
    finally:
        gc.enable()


def test_other_work_of_this_process_keeps_its_own_scheduler(monkeypatch: pytest.MonkeyPatch) -> None:
    """Writing a NetCDF file asks Dask for the scheduler, also after none has answered."""
    monkeypatch.setattr("flexros.scheduler.ANSWER", 0.2)
    with dask.config.set(scheduler="threads"):
        with pytest.raises(InputError), connected("tcp://127.0.0.1:1"):
            pytest.fail("nobody answers there")
        assert dask.config.get("scheduler") == "threads"
        with connected(threads=1):
            assert dask.config.get("scheduler") == "threads"


def test_workers_of_this_process_listen_to_this_machine_only() -> None:
    before = listening()
    with connected(threads=1):
        assert {address for address in listening() - before if not address.startswith("127.0.0.1:")} == set()


def listening() -> set[str]:
    """Addresses on which this process listens."""
    connections = psutil.Process().net_connections(kind="inet")
    return {f"{one.laddr.ip}:{one.laddr.port}" for one in connections if one.status == psutil.CONN_LISTEN}


def test_a_worker_of_this_process_is_not_given_up_where_the_machine_sleeps() -> None:
    """The scheduler removes workers of which it has not heard for minutes, and would wait for others for ever."""
    with connected(threads=1) as client:
        assert "worker-ttl" not in client.cluster.scheduler.periodic_callbacks
