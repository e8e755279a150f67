"""The identification node: equal to the direct simulation, progress, and its services start, stop and status."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader

from flexros.errors import InputError
from flexros.logs.messages.diagnostic_array import DiagnosticArrayCodec
from flexros.logs.reader import read_log
from flexros.logs.time_series import Log
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario

pytest.importorskip("rclpy", reason="needs ROS 2")

import rclpy
from rclpy.parameter import Parameter
from std_srvs.srv import Trigger

from flexros_nodes.bringup.run import run_scenario
from flexros_nodes.controller.node import ControllerNode
from flexros_nodes.identification import IdentificationNode
from flexros_nodes.plant.node import PlantNode
from flexros_nodes.protocol.experiment_state import ExperimentCourse
from flexros_nodes.recorder import RecorderNode

Bench = Any  # the class is in conftest
Differences = Callable[[Log, Log], list[str]]
TIMEOUT = 60.0


class Loop:
    """All nodes of an identification on a bench, with a user who calls the services."""

    def __init__(self, bench: Bench, scenario: Path, folder: Path, **plant: Any) -> None:
        self.bench = bench
        self.recorder = bench.add(RecorderNode, scenario=str(scenario), folder=str(folder))
        self.leader = bench.add(IdentificationNode, scenario=str(scenario), begin_at_once=False)
        self.controller = bench.add(ControllerNode, scenario=str(scenario))
        self.plant = bench.add(PlantNode, scenario=str(scenario), **plant)
        self.user = bench.hold(rclpy.create_node("user", context=bench.context))
        self.all = (self.recorder, self.leader, self.controller, self.plant)
        self._clients: dict[str, Any] = {}

    def bring_up(self) -> None:
        for node in self.all:
            node.trigger_configure()
        for node in self.all:
            node.trigger_activate()

    def call(self, name: str) -> Trigger.Response:
        if name not in self._clients:
            self._clients[name] = self.user.create_client(Trigger, f"identification/{name}")
        client = self._clients[name]
        self.bench.spin_until(client.service_is_ready)
        future = client.call_async(Trigger.Request())
        self.bench.spin_until(future.done)
        return future.result()

    def status(self) -> dict[str, Any]:
        answer = self.call("status")
        assert answer.success
        return json.loads(answer.message)

    def finish(self) -> None:
        self.bench.spin_until(lambda: self.plant.report is not None)
        assert (self.plant.report.exit_code, self.plant.report.message) == (0, "")
        for node in reversed(self.all):
            node.trigger_shutdown()


@pytest.fixture
def loop(bench: Bench, identification_scenario: Path, tmp_path: Path) -> Loop:
    return Loop(bench, identification_scenario, tmp_path / "log", start_timeout=0.6, partner_timeout=0.6)


def direct(path: Path) -> Log:
    return closed_loop(Experiment.prepare(load_scenario(path)))


@pytest.mark.usefixtures("ros_domain")
def test_log_equals_the_direct_simulation(
    tmp_path: Path, identification_scenario: Path, log_differences: Differences
) -> None:
    summary = run_scenario(identification_scenario, tmp_path / "log")
    assert (summary.exit_code, summary.message, summary.missing) == (0, "", 0)
    assert set(summary.reports) == {"recorder", "identification", "controller", "plant"}
    assert summary.reports["identification"].figures["completed"] == 4
    log = read_log(tmp_path / "log")
    assert log_differences(direct(identification_scenario), log) == []
    assert "stopped" not in log.provenance


@pytest.mark.usefixtures("ros_domain")
def test_progress_is_in_the_log(tmp_path: Path, identification_scenario: Path) -> None:
    run_scenario(identification_scenario, tmp_path / "log")
    with (tmp_path / "log" / "log_0.mcap").open("rb") as file:
        messages = [entry.data for _, _, entry in make_reader(file).iter_messages(topics=["/diagnostics"])]
    said = [
        status for data in messages for status in DiagnosticArrayCodec().read(data) if status.name == "/identification"
    ]
    completed = [status.numbers()["completed"] for status in said]
    assert set(completed) == {0.0, 1.0, 2.0, 3.0, 4.0}
    assert sorted(completed) == completed
    assert all("position" in status.message for status in said if 0.0 < status.numbers()["completed"] < 4.0)
    assert {status.numbers()["position"] for status in said} == {1.0, 2.0}


def test_experiment_waits_for_its_start_longer_than_a_partner_may_be_silent(
    loop: Loop, identification_scenario: Path, tmp_path: Path, log_differences: Differences
) -> None:
    loop.bring_up()
    loop.bench.spin_for(1.5)
    waiting = loop.status()
    assert (waiting["state"], waiting["completed"], waiting["planned"]) == ("waiting", 0, 4)
    answer = loop.call("start")
    assert answer.success
    assert answer.message.startswith("the experiment begins; it takes ")
    again = loop.call("start")
    assert not again.success
    assert again.message.startswith("the experiment has been started already: ")
    loop.finish()
    assert log_differences(direct(identification_scenario), read_log(tmp_path / "log")) == []


def test_plant_aborts_without_a_waiting_experiment(bench: Bench, identification_scenario: Path) -> None:
    controller = bench.add(ControllerNode, scenario=str(identification_scenario), observers=0)
    plant = bench.add(PlantNode, scenario=str(identification_scenario), observers=0, start_timeout=0.3)
    for node in (controller, plant):
        node.trigger_configure()
        node.trigger_activate()
    bench.spin_until(lambda: plant.report is not None)
    assert plant.report.exit_code == 3
    assert "the controller is gone or lacks its reference" in plant.report.message


def test_stopped_experiment_comes_to_rest_and_its_log_records_it(
    loop: Loop, identification_scenario: Path, tmp_path: Path
) -> None:
    run = Experiment.prepare(load_scenario(identification_scenario))
    assert run.plan is not None
    second = run.plan.segments[1]
    loop.bring_up()
    loop.call("start")
    loop.bench.spin_until(lambda: loop.leader.stream.progress > second.first)
    answer = loop.call("stop")
    assert answer.success
    assert answer.message.startswith("stopped at position ")
    loop.finish()
    log = read_log(tmp_path / "log")
    stopped = log.provenance["stopped"]
    at, last = stopped["stopped_at_sample"], stopped["last_sample"]
    assert (stopped["state"], stopped["planned"]) == ("stopping", 4)
    assert stopped["completed"] == ExperimentCourse(run.plan).n_completed(at)
    assert 2 * at < 2 * last < 2 * run.n_samples
    assert len(log.joint_states.stamp) == last + 1
    assert log.joint_reference is not None
    assert log.joint_reference.velocity is not None
    reference = log.joint_reference.velocity
    assert np.array_equal(reference[:at], run.reference.motor_velocity[:at])
    rest = at + ExperimentCourse(run.plan).n_slowing(at)
    assert np.array_equal(reference[rest:], np.zeros((last + 1 - rest, 1)))
    assert last + 1 - rest > 500  # 0.5 s
    assert np.abs(np.diff(log.joint_states.position[-50:], axis=0)).max() < 1e-3
    assert loop.recorder.report.figures["joint_states.missing"] == 0
    assert loop.leader.report.figures["completed"] == stopped["completed"]


def test_stop_can_be_asked_for_twice(loop: Loop) -> None:
    loop.bring_up()
    loop.call("start")
    loop.call("stop")
    again = loop.call("stop")
    assert again.success
    assert again.message.startswith("the experiment has been stopped already: ")
    start = loop.call("start")
    assert not start.success
    assert start.message.startswith("the experiment was stopped (stopped ")
    assert start.message.endswith("); run it again")
    loop.finish()


def test_stop_of_an_experiment_that_waits_ends_a_run_at_rest(
    loop: Loop, identification_scenario: Path, tmp_path: Path
) -> None:
    run = Experiment.prepare(load_scenario(identification_scenario))
    loop.bring_up()
    stop = loop.call("stop")
    assert stop.success
    assert stop.message.startswith("stopped before the start; no experiment was run; the run ends in ")
    start = loop.call("start")
    assert not start.success
    assert start.message == "the experiment was stopped (stopped before the start; no experiment was run); run it again"
    loop.finish()
    log = read_log(tmp_path / "log")
    assert (log.provenance["stopped"]["stopped_at_sample"], log.provenance["stopped"]["completed"]) == (0, 0)
    assert len(log.joint_states.stamp) == log.provenance["stopped"]["last_sample"] + 1 < run.n_samples / 2
    assert log.joint_reference is not None
    assert log.joint_reference.position is not None
    assert np.abs(log.joint_reference.position - run.start_motor_position).max() < 1e-9


def test_stop_when_everything_is_sent_lets_the_plan_end(loop: Loop, tmp_path: Path) -> None:
    loop.leader.set_parameters([Parameter("lead", value=60.0)])
    loop.bring_up()
    loop.call("start")
    loop.bench.spin_until(lambda: loop.leader.stream.sent == loop.leader.run.n_samples)
    answer = loop.call("stop")
    assert answer.success
    assert answer.message.startswith("the experiment ends by itself within ")
    loop.finish()
    assert "stopped" not in read_log(tmp_path / "log").provenance


def test_services_refuse_while_the_node_is_not_active(loop: Loop) -> None:
    loop.leader.trigger_configure()
    answer = loop.call("start")
    assert not answer.success
    assert answer.message == "node identification is not active; activate it first"


def test_services_and_topics_go_with_the_clean_up(loop: Loop) -> None:
    node = loop.leader
    before = len(list(node.services)), len(list(node.publishers))
    for _ in range(2):
        node.trigger_configure()
        assert len(list(node.services)) == before[0] + 3
        node.trigger_activate()
        node.trigger_deactivate()
        node.trigger_cleanup()
        assert (len(list(node.services)), len(list(node.publishers))) == before


def test_scenario_without_the_key_is_bad_input(bench: Bench) -> None:
    node = bench.add(IdentificationNode)
    node.trigger_configure()
    assert node.report.exit_code == 2
    assert node.report.message == (
        "scenario circle_dae has no key identification, which node identification needs; add the key, or use node "
        "feedforward"
    )


def test_parameters_of_the_node_that_is_left_out_are_bad_input(identification_scenario: Path) -> None:
    with pytest.raises(InputError, match="parameters of node feedforward are given, but in scenario identify node ide"):
        run_scenario(identification_scenario, None, parameters={"feedforward": {"lead": 1.0}})
    with pytest.raises(InputError, match="but in scenario circle_dae node feedforward streams the reference; give its"):
        run_scenario("circle_dae", None, parameters={"identification": {"lead": 1.0}})


def test_executable_waits_for_the_service_and_runs(
    bench: Bench,
    start_node: Callable[..., subprocess.Popen[str]],
    end_with_plant: Callable[..., str],
    tmp_path: Path,
    identification_scenario: Path,
    log_differences: Differences,
) -> None:
    scenario = str(identification_scenario)
    plant = start_node("plant", f"scenario:={scenario}")
    leader = start_node("identification", f"scenario:={scenario}", "begin_at_once:=false")
    here = [
        bench.add(ControllerNode, scenario=scenario),
        bench.add(RecorderNode, scenario=scenario, folder=str(tmp_path / "log")),
    ]
    for node in here:
        node.trigger_configure()
        node.trigger_activate()
    user = bench.hold(rclpy.create_node("user", context=bench.context))
    client = user.create_client(Trigger, "identification/start")
    bench.spin_until(client.service_is_ready, TIMEOUT)
    answers: list[Trigger.Response] = []
    while not answers or not answers[-1].success:  # refused until the node is active
        future = client.call_async(Trigger.Request())
        bench.spin_until(future.done)
        answers.append(future.result())
    end_with_plant(plant, leader, spin=lambda: bench.spin_for(0.02))
    for node in here:
        node.trigger_shutdown()
    assert log_differences(direct(identification_scenario), read_log(tmp_path / "log")) == []
