"""Runs with one process per node: equal to the direct simulation, and aborted in order when one dies."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable
from pathlib import Path

import pytest

from flexros.errors import InputError
from flexros.logs.reader import read_log
from flexros.logs.time_series import Log
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario

pytest.importorskip("rclpy", reason="needs ROS 2")

from lifecycle_msgs.srv import ChangeState
from rclpy.client import Client
from rclpy.task import Future

from flexros_nodes.bringup import processes
from flexros_nodes.bringup.processes import ProcessManager
from flexros_nodes.bringup.run import run_scenario
from flexros_nodes.bringup.run_plan import RunPlan
from flexros_nodes.protocol.process.interruption import Interruption
from tests.segments import left_ports

pytestmark = pytest.mark.usefixtures("ros_domain")

LOSS = {"drop_fraction": 0.01}


@pytest.mark.parametrize(("victim", "real_time"), [("controller", True), ("recorder", False)])
def test_killed_node_aborts_the_run(
    tmp_path: Path, long_scenario: Path, monkeypatch: pytest.MonkeyPatch, victim: str, real_time: bool, ros_domain: int
) -> None:
    killed: list[int] = []
    wait = ProcessManager.wait

    def kill_and_wait(self: ProcessManager, condition: Callable[[], bool], timeout: float | None) -> bool:
        def check() -> bool:
            log = tmp_path / "log" / "log_0.mcap"
            if not killed and log.is_file() and log.stat().st_size > 300_000:
                killed.append(self.processes[victim].pid)
                os.kill(killed[0], signal.SIGKILL)
            return condition()

        return wait(self, check, timeout)

    monkeypatch.setattr(ProcessManager, "wait", kill_and_wait)
    # the plant itself would wait for long: it is told
    parameters = {"plant": {"partner_timeout": 3600.0, "real_time_patience": 10.0, "brake_duration": 0.01}}
    summary = run_scenario(long_scenario, tmp_path / "log", "processes", real_time=real_time, parameters=parameters)
    assert summary.exit_code == 3, summary.message
    assert f"the process of node {victim} was killed by SIGKILL" in summary.message
    log = read_log(tmp_path / "log")
    assert len(log.joint_states.stamp) > 500
    if victim == "controller":
        assert "a partner of the plant exited at sample" in summary.message
        assert summary.message.endswith("the plant has braked to zero torque; the log is valid up to that point")
        assert summary.reports["plant"].figures["braked_samples"] == 20
    assert not left_ports(ros_domain), "the run left segments that nobody uses"


def test_child_that_offers_only_some_services_is_started_once_more(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    begin = ProcessManager.__init__
    started: list[int] = []

    class Deaf:
        """A client that discovery has missed until the process is started again."""

        def __init__(self, manager: ProcessManager, client: Client) -> None:
            self._manager, self._client = manager, client

        def service_is_ready(self) -> bool:
            return self._manager.processes["recorder"].pid != started[0] and self._client.service_is_ready()

        def call_async(self, request: object) -> Future:
            return self._client.call_async(request)

    def begin_deaf(self: ProcessManager, *arguments: object) -> None:
        begin(self, *arguments)
        started.append(self.processes["recorder"].pid)
        self._watchers["recorder"] = Deaf(self, self._watchers["recorder"])

    def await_recorder(self: ProcessManager) -> None:
        self.await_services("recorder")
        started.append(self.processes["recorder"].pid)
        monkeypatch.setattr(processes, "START_TIMEOUT", 30.0)
        self.await_services("recorder")
        ready.append(self._watchers["recorder"].service_is_ready())

    ready: list[bool] = []
    monkeypatch.setattr(RunPlan, "nodes", ("recorder",))  # the others take no part
    monkeypatch.setattr(ProcessManager, "__init__", begin_deaf)
    monkeypatch.setattr(ProcessManager, "run", await_recorder)
    monkeypatch.setattr(processes, "START_TIMEOUT", 3.0)
    run_scenario("circle_dae", tmp_path / "log", "processes")
    first, second = started
    assert first != second
    assert ready == [True]


def test_node_killed_while_it_starts_leaves_a_closed_log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    change = ProcessManager.change_state

    def kill_and_change(self: ProcessManager, name: str, transition: int, timeout: float) -> bool:
        if name == "controller":
            os.kill(self.processes[name].pid, signal.SIGKILL)
        return change(self, name, transition, timeout)

    monkeypatch.setattr(RunPlan, "nodes", ("recorder", "controller"))  # the others take no part
    monkeypatch.setattr(ProcessManager, "change_state", kill_and_change)
    summary = run_scenario("circle_dae", tmp_path / "log", "processes")
    assert summary.exit_code == 3
    assert summary.message == "the process of node controller was killed by SIGKILL; the log holds no samples"
    assert (tmp_path / "log" / "log_0.mcap").read_bytes().endswith(b"\x89MCAP0\r\n")


def test_bad_parameter_of_a_process_is_bad_input(tmp_path: Path) -> None:
    parameters = {"controller": {"drop_fraction": 2.0}}
    with pytest.raises(InputError, match="drop_fraction of node controller is 2, allowed is a number from 0 to 0.9"):
        run_scenario("circle_dae", tmp_path / "log", "processes", parameters=parameters)


def test_log_equals_the_direct_simulation_though_messages_and_answers_of_lifecycle_services_are_lost(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, log_differences: Callable[[Log, Log], list[str]]
) -> None:
    ask = ProcessManager.request
    lost: list[object] = []

    def ask_and_lose(
        self: ProcessManager, name: str, client: Client, request: object, deadline: float
    ) -> Future | None:
        answer = ask(self, name, client, request, deadline)
        if len(lost) < 2 and isinstance(request, ChangeState.Request):
            lost.append(answer)
            return Future()
        return answer

    monkeypatch.setattr(ProcessManager, "request", ask_and_lose)
    monkeypatch.setattr(processes, "ANSWER_TIMEOUT", 0.3)
    parameters = {"plant": LOSS, "controller": LOSS}
    summary = run_scenario("circle_dae", tmp_path / "log", "processes", parameters=parameters)
    assert (summary.exit_code, summary.message, summary.missing, summary.samples) == (0, "", 0, 762)
    assert len(lost) == 2
    assert summary.dropped > 0
    reference = closed_loop(Experiment.prepare(load_scenario("circle_dae")))
    assert log_differences(reference, read_log(tmp_path / "log")) == []


def test_segments_of_a_child_that_was_killed_and_started_once_more_are_removed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ros_domain: int
) -> None:
    class Child:
        """A process that offers no services; the first one does not end when it is asked to."""

        ended, made = False, 0

        def __init__(self, *_: object) -> None:
            Child.made += 1
            self._is_first = Child.made == 1
            self.killed = False

        def request_stop(self) -> None:
            pass

        def stop(self, _: float) -> None:
            self.killed = self._is_first

    removals: list[str] = []
    monkeypatch.setattr(processes, "NodeProcess", Child)
    monkeypatch.setattr(processes, "START_TIMEOUT", 0.01)
    monkeypatch.setattr(processes, "remove_segments_without_owner", lambda: removals.append("removed"))
    manager = ProcessManager(RunPlan("circle_dae", tmp_path / "log", {}), tmp_path, Interruption())
    first = next(iter(manager.processes))
    manager.await_services(first)
    assert not manager.processes[first].killed
    manager.close()
    assert removals == ["removed"]
