"""Removal of nodes from the graph."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from pathlib import Path
from time import monotonic
from typing import Any, cast

import pytest

from flexros_nodes.shell.removal import DEPARTURE_TIMEOUT, await_departures, limited_removal

HANG = "import ctypes; ctypes.PyDLL(None).pause()"  # PyDLL keeps the lock of Python meanwhile, as the middleware does


def run_python(code: str) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[3])}
    return subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, timeout=30.0)


def test_process_that_the_middleware_does_not_let_go_is_ended_by_the_system() -> None:
    limit = "from flexros_nodes.shell import removal; removal.REMOVAL_TIMEOUT = 0.2\n"
    assert run_python(f"{limit}with removal.limited_removal(): {HANG}").returncode == -signal.SIGALRM


@pytest.mark.parametrize("code", [0, 3])
def test_node_whose_work_is_done_ends_as_it_would_have(code: int) -> None:
    limit = f"from flexros_nodes.shell import removal; removal.end_within(0.2, {code})\n"
    assert run_python(limit + HANG).returncode == code


@pytest.mark.usefixtures("ros_domain")
def test_node_that_the_middleware_does_not_let_go_ends_with_the_code_of_its_report() -> None:
    """Fast DDS that spins with the lock of Python is a `destroy_node` that never ends."""
    lines = (
        "import ctypes, sys",
        "from flexros_nodes.feedforward import FeedforwardNode",
        "from flexros_nodes.shell import executable",
        "executable.END_TIMEOUT = 0.2",
        "FeedforwardNode.destroy_node = lambda _: [print('hangs', flush=True), ctypes.PyDLL(None).pause()]",
        "sys.exit(executable.run_node(FeedforwardNode, ['--ros-args', '-p', 'scenario:=nowhere']))",
    )
    ended = run_python("\n".join(lines))
    assert (ended.stdout, ended.returncode) == ("hangs\n", 2), ended.stderr


def test_timer_of_the_user_goes_on_after_the_removal() -> None:
    heard: list[int] = []
    before = signal.signal(signal.SIGALRM, lambda number, _: heard.append(number))
    try:
        signal.setitimer(signal.ITIMER_REAL, 100.0)
        with limited_removal():
            assert signal.getitimer(signal.ITIMER_REAL)[0] < 99.0
        assert signal.getitimer(signal.ITIMER_REAL)[0] > 99.0
        signal.raise_signal(signal.SIGALRM)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
    assert heard == [signal.SIGALRM]


def test_other_threads_cannot_set_a_limit() -> None:
    limits: list[float] = []

    def remove() -> None:
        with limited_removal():
            limits.append(signal.getitimer(signal.ITIMER_REAL)[0])

    thread = threading.Thread(target=remove)
    thread.start()
    thread.join()
    assert limits == [0.0]


class Graph:
    """A node that sees other nodes, from one look to the next."""

    def __init__(self, *looks: list[str]) -> None:
        self._looks = list(looks)
        self.n_looks = 0

    def get_node_names(self) -> list[str]:
        self.n_looks += 1
        return self._looks.pop(0) if len(self._looks) > 1 else self._looks[0]


def test_partners_that_have_ended_are_awaited_and_nodes_of_the_user_are_not() -> None:
    graph = Graph(["plant", "recorder", "mine"], ["plant", "recorder", "mine"], ["plant", "mine"])
    await_departures(cast("Any", graph), ["recorder", "feedforward"])
    assert graph.n_looks == 3
    await_departures(cast("Any", graph), [])
    assert graph.n_looks == 3


def test_killed_partner_is_not_awaited_for_long() -> None:
    began = monotonic()
    await_departures(cast("Any", Graph(["recorder"])), ["recorder"])
    assert DEPARTURE_TIMEOUT <= monotonic() - began < DEPARTURE_TIMEOUT + 5.0
