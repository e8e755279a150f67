"""Ctrl-C and termination: orderly shutdown, exit code 130, closed log, no process left."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from time import monotonic, process_time

import pytest

from flexros.logs.reader import read_log
from flexros.scenario.scenario import load_scenario

pytest.importorskip("rclpy", reason="needs ROS 2")

from rclpy.node import Node
from rclpy.waitable import Waitable

from flexros_nodes.bringup import composed
from flexros_nodes.bringup.run import run_scenario
from flexros_nodes.feedforward import FeedforwardNode
from flexros_nodes.protocol.process.interruption import (
    PARTNER_ENDED,
    interruptible,
    interruption,
    uninterruptible,
)
from tests.segments import left_ports

CHECKOUT = Path(__file__).parents[4]
TIMEOUT = 60.0

RUN = """
import sys
from pathlib import Path
from flexros_nodes.bringup.run import run_scenario
summary = run_scenario(Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3])
print(summary.message)
sys.exit(summary.exit_code)
"""


def wait_until(condition: Callable[[], bool], otherwise: str) -> None:
    """Wait until a condition holds."""
    pause = threading.Event()
    for _ in range(int(TIMEOUT / 0.05)):
        if condition():
            return
        pause.wait(0.05)
    raise AssertionError(otherwise)


def grow_beyond(file: Path, size: int, process: subprocess.Popen[str]) -> None:
    """Wait until a file is larger than a size [byte]."""

    def grown() -> bool:
        assert process.poll() is None, process.communicate()
        return file.is_file() and file.stat().st_size > size

    wait_until(grown, f"{file} did not grow beyond {size} bytes")


def children(pid: int) -> list[int]:
    return [int(text) for text in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]


def exists(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


@pytest.mark.usefixtures("ros_domain")
@pytest.mark.parametrize(("layout", "number"), [("composed", signal.SIGTERM), ("processes", signal.SIGINT)])
def test_interrupted_run_closes_its_log(
    tmp_path: Path, long_scenario: Path, layout: str, number: signal.Signals
) -> None:
    folder = tmp_path / "log"
    process = subprocess.Popen(
        [sys.executable, "-c", RUN, str(long_scenario), str(folder), layout],
        cwd=CHECKOUT,
        env={**os.environ, "PYTHONPATH": str(CHECKOUT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        grow_beyond(folder / "log_0.mcap", 200_000, process)
        nodes = children(process.pid)
        assert len(nodes) == (4 if layout == "processes" else 0)
        process.send_signal(number)
        output, errors = process.communicate(timeout=TIMEOUT)
    finally:
        process.kill()
    assert process.returncode == 130, errors
    assert "interrupted; the log is valid up to that point" in output
    assert not any(exists(pid) for pid in nodes)
    log = read_log(folder)
    assert log.warnings == ()
    assert len(log.joint_states.stamp) > 300


def test_nodes_do_not_outlive_a_killed_run(tmp_path: Path, long_scenario: Path, ros_domain: int) -> None:
    folder = tmp_path / "log"
    process = subprocess.Popen(
        [sys.executable, "-c", RUN, str(long_scenario), str(folder), "processes"],
        cwd=CHECKOUT,
        env={**os.environ, "PYTHONPATH": str(CHECKOUT), "TMPDIR": str(tmp_path)},
    )
    try:
        grow_beyond(folder / "log_0.mcap", 100_000, process)
        nodes = children(process.pid)
    finally:
        process.kill()
        process.wait()
    assert len(nodes) == 4
    wait_until(lambda: not any(exists(pid) for pid in nodes), "a node lives on")
    assert read_log(folder).warnings == ()
    assert not left_ports(ros_domain), "the nodes left segments that nobody uses"


@pytest.mark.usefixtures("ros_domain")
@pytest.mark.parametrize("layout", ["composed", "processes"])
def test_run_is_interrupted_while_it_prepares_its_reference(tmp_path: Path, layout: str) -> None:
    """The reference of a circle of 900 s takes far longer than the interruption may."""
    settings = {**load_scenario("circle_dae").settings(), "duration": 900.0}
    scenario = tmp_path / "long.yaml"
    scenario.write_text(json.dumps(settings))
    process = subprocess.Popen(
        [sys.executable, "-c", RUN, str(scenario), str(tmp_path / "log"), layout],
        cwd=CHECKOUT,
        env={**os.environ, "PYTHONPATH": str(CHECKOUT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        # the recorder is configured first: then the reference is being prepared
        wait_until((tmp_path / "log" / "log_0.mcap").is_file, "no log was begun")
        began = monotonic()
        process.send_signal(signal.SIGTERM)
        output, errors = process.communicate(timeout=TIMEOUT)
    finally:
        process.kill()
    assert process.returncode == 130, errors
    assert "interrupted; the log holds no samples" in output
    assert monotonic() - began < 10.0


def test_request_raises_only_where_work_is_interruptible() -> None:
    with interruption() as interrupted:
        with pytest.raises(KeyboardInterrupt), interruptible():
            signal.raise_signal(signal.SIGTERM)
        assert interrupted()
        signal.raise_signal(signal.SIGTERM)
        with pytest.raises(KeyboardInterrupt), interruptible():  # it was asked for before
            pass
    with interruptible():
        pass


def test_request_waits_for_the_end_of_work_that_must_not_be_left_half_done() -> None:
    done: list[int] = []

    @uninterruptible()
    def work() -> None:
        signal.raise_signal(signal.SIGTERM)
        done.append(1)

    with interruption(), pytest.raises(KeyboardInterrupt), interruptible():
        work()
    with interruption():
        work()  # nothing is interruptible here: the loop polls the flag
    assert done == [1, 1]


@pytest.mark.parametrize("after", [lambda: float("no number"), lambda: None])
def test_request_that_foreign_code_swallows_still_ends_the_work(after: Callable[[], object]) -> None:
    """CasADi lost a KeyboardInterrupt and returned None; a node then reported an internal error."""

    def work() -> None:
        with interruptible():
            with suppress(KeyboardInterrupt):
                signal.raise_signal(signal.SIGINT)
            after()

    with interruption() as interrupted:
        with pytest.raises(KeyboardInterrupt):
            work()
        assert interrupted()


def test_work_that_goes_on_although_it_was_requested_to_end_is_reminded() -> None:
    def work() -> None:
        with suppress(KeyboardInterrupt):
            signal.raise_signal(signal.SIGTERM)
        while process_time() - began < TIMEOUT:
            sum(range(100_000))

    began = process_time()
    with interruption(), pytest.raises(KeyboardInterrupt), interruptible():
        work()
    assert process_time() - began < TIMEOUT
    assert signal.getitimer(signal.ITIMER_VIRTUAL)[0] == 0


def test_error_without_a_request_stays_what_it_is() -> None:
    with interruption(), pytest.raises(ValueError, match="own"), interruptible():
        raise ValueError("own")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_signal_is_noted_and_handlers_come_back(number: signal.Signals) -> None:
    def own(*_: object) -> None:
        raise AssertionError("the handler of the command is replaced for the time of the run")

    before = signal.signal(number, own)
    try:
        with interruption() as interrupted:
            assert not interrupted()
            signal.raise_signal(number)
            assert interrupted()
        assert signal.getsignal(number) is own
    finally:
        signal.signal(number, before)


def test_exit_of_a_partner_is_not_an_interruption() -> None:
    with interruption() as interrupted:
        signal.raise_signal(PARTNER_ENDED)
        assert interrupted.partner_ended
        assert not interrupted()


@pytest.mark.usefixtures("ros_domain")
def test_run_interrupted_before_its_first_sample_reports_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    class Interrupted(FeedforwardNode):
        def configure(self) -> None:
            super().configure()
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setitem(composed.NODE_CLASSES, "feedforward", Interrupted)
    summary = run_scenario("circle_dae", tmp_path / "log")
    assert (summary.exit_code, summary.message) == (130, "interrupted; the log holds no samples")
    assert (tmp_path / "log" / "log_0.mcap").read_bytes().endswith(b"\x89MCAP0\r\n")


@pytest.mark.usefixtures("ros_domain")
def test_run_interrupted_while_a_node_subscribes_is_closed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """rclpy cannot destroy a node with a subscription that is half made: the run ended with its traceback."""
    add = Node.add_waitable

    def interrupted(node: Node, waitable: Waitable) -> None:
        if list(node.subscriptions):
            signal.raise_signal(signal.SIGTERM)
        add(node, waitable)

    monkeypatch.setattr(Node, "add_waitable", interrupted)
    assert run_scenario("circle_dae", tmp_path / "log").exit_code == 130


def test_thread_leaves_signals_alone() -> None:
    noted: list[bool] = []

    def work() -> None:
        with interruption() as interrupted:
            noted.append(interrupted())

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert noted == [False]
