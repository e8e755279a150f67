"""Start, pause, step and reset of the plant, in lock-step and in real time."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flexros.logs.messages.joint_state import JointStateView
from flexros.logs.reader import read_log
from flexros.logs.stamps import START_NS, sample_number, stamp_of
from flexros.logs.time_series import Log
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario

pytest.importorskip("rclpy", reason="needs ROS 2")

import rclpy
from rclpy.parameter import Parameter
from std_srvs.srv import Trigger

from flexros_nodes.controller.node import ControllerNode
from flexros_nodes.feedforward import FeedforwardNode
from flexros_nodes.identification import IdentificationNode
from flexros_nodes.plant.node import PlantNode
from flexros_nodes.recorder import RecorderNode
from tests.nodes.loop_on_bench import Loop

pytestmark = pytest.mark.slow

Bench = Any  # the class is in conftest
Differences = Callable[[Log, Log], list[str]]
IMPATIENT = {"start_timeout": 0.3, "partner_timeout": 0.3, "recorder_timeout": 0.3}
T = 5e-4
LONGER = 0.9
TIMEOUT = 60.0


def direct(path: Path) -> Log:
    return closed_loop(Experiment.prepare(load_scenario(path)))


def test_log_of_a_run_that_was_paused_and_stepped_is_the_same_in_every_bit(
    bench: Bench, short_scenario: Path, tmp_path: Path, log_differences: Differences
) -> None:
    loop = Loop(bench, short_scenario, RecorderNode, FeedforwardNode, ControllerNode, begin_at_once=False, **IMPATIENT)
    loop.node(RecorderNode).set_parameters([Parameter("folder", value=str(tmp_path / "log"))])
    loop.bring_up()
    bench.spin_for(LONGER)  # no time-out counts before the start
    assert loop.sample == 0
    for sample in (1, 2, 3):
        loop.step()
        assert loop.sample == sample
    assert loop.call("start").success
    loop.reach(150)
    assert loop.call("pause").success
    paused = loop.sample
    bench.spin_for(LONGER)  # nor in a pause
    assert loop.sample == paused < 400
    loop.step()
    assert loop.sample == paused + 1
    place = f"sample {paused + 1} (stamp {1 + (paused + 1) * T:.4f} s)"
    assert loop.call("start").message == f"the plant continues from {place}"
    loop.finish()
    assert log_differences(direct(short_scenario), read_log(tmp_path / "log")) == []


def test_clock_never_decreases_through_pause_and_step(bench: Bench, short_scenario: Path) -> None:
    loop = Loop(bench, short_scenario, FeedforwardNode, ControllerNode)
    clock = loop.hear("clock")
    loop.bring_up()
    loop.reach(100)
    loop.call("pause")
    for _ in range(45):
        loop.step()
    loop.call("start")
    loop.finish()
    stamps = [stamp_of(message) for message in clock]
    assert len(set(stamps)) > 10
    assert stamps == sorted(stamps)


def test_pause_in_which_the_command_was_lost_sends_the_state_again(bench: Bench, short_scenario: Path) -> None:
    loop = Loop(bench, short_scenario, FeedforwardNode, ControllerNode)
    loop.bring_up()
    loop.reach(100)
    loop.node(ControllerNode).active = False  # it hears nothing
    bench.spin_for(0.05)
    loop.call("pause")
    waiting = loop.sample
    assert loop.call("step").message == f"sample {waiting + 1} follows with the command of sample {waiting}"
    second = loop.call("step")
    assert not second.success
    assert second.message == f"the previous step still waits for the command of sample {waiting}; try again"
    loop.node(ControllerNode).active = True
    bench.spin_until(lambda: loop.sample == waiting + 1)
    loop.call("start")
    loop.finish()


def test_services_say_what_they_refuse(bench: Bench, short_scenario: Path) -> None:
    loop = Loop(bench, short_scenario, ControllerNode, begin_at_once=False)
    loop.plant.trigger_configure()
    assert loop.call("start").message == "node plant is not active; activate it first"
    loop.plant.trigger_activate()
    beginning = "its beginning, waiting for controller and recorder"
    step = loop.call("step")
    assert not step.success
    assert step.message == f"the plant is at {beginning}; step once they are connected"
    assert loop.call("pause").message == f"the plant is paused already at {beginning}"
    assert loop.call("start").success
    again = loop.call("start")
    assert not again.success
    assert again.message == f"the plant is not paused; it is at {beginning}"
    step = loop.call("step")
    assert not step.success
    assert step.message == "the plant is not paused; call pause before a step"


def test_last_step_ends_the_run(bench: Bench, short_scenario: Path) -> None:
    loop = Loop(bench, short_scenario, FeedforwardNode, ControllerNode)
    loop.plant.set_parameters([Parameter("begin_at_once", value=False)])
    loop.bring_up()
    bench.spin_until(lambda: loop.sample == 0)
    loop.call("start")
    loop.reach(300)
    loop.call("pause")
    while loop.sample < 400:
        loop.step()
    assert loop.call("step").success
    loop.finish()


def test_partner_that_ends_in_a_pause_lets_the_plant_brake(bench: Bench, short_scenario: Path) -> None:
    loop = Loop(bench, short_scenario, FeedforwardNode, ControllerNode, brake_duration=0.01)
    loop.bring_up()
    loop.reach(100)
    loop.call("pause")
    loop.plant.partner_ended()
    bench.spin_until(lambda: loop.plant.report is not None)
    assert loop.plant.report.exit_code == 3
    assert loop.plant.report.figures["braked_samples"] == 20


def positions(messages: list[bytes]) -> np.ndarray:
    """Measured positions by sample; repeats must be equal."""
    view = JointStateView(("motor_1", "motor_2"))
    by_stamp: dict[int, tuple[float, ...]] = {}
    for message in messages:
        sample = view.unpack(message)
        assert by_stamp.setdefault(sample.stamp_ns, sample.position) == sample.position
    return np.array([by_stamp[stamp] for stamp in sorted(by_stamp)])


@pytest.mark.parametrize("paused", [False, True])
def test_run_after_a_reset_is_the_same_in_every_bit(bench: Bench, short_scenario: Path, paused: bool) -> None:
    loop = Loop(bench, short_scenario, FeedforwardNode, ControllerNode)
    states = loop.hear("joint_states")
    loop.bring_up()
    loop.reach(150)
    if paused:
        loop.call("pause")
    answer = loop.call("reset")
    assert (answer.success, answer.message) == (True, "the plant is back before its first sample")
    if paused:
        bench.spin_for(0.1)
        assert loop.sample == 0
        loop.call("start")
    loop.finish()
    beginning = max(i for i, message in enumerate(states) if stamp_of(message) == START_NS)
    once, again = positions(states[:100]), positions(states[beginning:])
    expected = direct(short_scenario).joint_states.position
    assert np.array_equal(again, expected)
    assert np.array_equal(once[:50], expected[:50])
    assert loop.plant.report.figures["samples"] == 401


def test_reset_is_refused_while_a_recorder_is_there(bench: Bench, short_scenario: Path, tmp_path: Path) -> None:
    loop = Loop(bench, short_scenario, RecorderNode, FeedforwardNode, ControllerNode)
    loop.node(RecorderNode).set_parameters([Parameter("folder", value=str(tmp_path / "log"))])
    loop.bring_up()
    loop.reach(100)
    loop.call("pause")
    answer = loop.call("reset")
    assert not answer.success
    assert answer.message.startswith("a recorder is connected, and its log cannot return to the first sample")
    loop.call("start")
    loop.finish()


def test_reset_before_the_second_sample_has_nothing_to_do(bench: Bench, short_scenario: Path) -> None:
    loop = Loop(bench, short_scenario, FeedforwardNode, ControllerNode, begin_at_once=False)
    loop.bring_up()
    bench.spin_until(lambda: loop.sample == 0)
    answer = loop.call("reset")
    assert (answer.success, answer.message) == (True, "the plant is at sample 0 (stamp 1.0000 s)")


def test_identification_restarts_with_a_reset(bench: Bench, identification_scenario: Path) -> None:
    loop = Loop(bench, identification_scenario, IdentificationNode, ControllerNode)
    loop.bring_up()
    loop.reach(2000)
    loop.call("reset")
    loop.finish()
    expected = closed_loop(Experiment.prepare(load_scenario(identification_scenario)))
    assert loop.plant.report.figures["samples"] == len(expected.joint_states.stamp)
    assert loop.plant.loop.plant.measure() == pytest.approx(expected.joint_states.position[-1], abs=0.0)


def test_real_time_resumes_after_a_pause_without_misses(bench: Bench, short_scenario: Path) -> None:
    loop = Loop(bench, short_scenario, FeedforwardNode, ControllerNode, real_time=True, begin_at_once=False)
    states = loop.hear("joint_states")
    loop.bring_up()
    bench.spin_until(lambda: loop.sample == 0)
    loop.step()
    loop.call("start")
    pacing = loop.plant.paced

    def turn(until: int) -> None:
        """Spin as whoever paces the plant, at a pace of its own, so that no machine is too slow."""
        while loop.sample < until:
            bench.spin_until(pacing.answered)
            pacing.schedule.started(pacing.schedule.due)
            pacing.cycle()

    bench.spin_until(lambda: pacing.schedule is not None)
    turn(100)
    assert loop.call("pause").success
    bench.spin_for(0.3)  # three times real_time_patience
    assert (loop.sample, pacing.schedule) == (100, None)
    loop.step()
    assert loop.sample == 101
    loop.call("start")
    turn(200)
    figures = loop.plant.figures()
    assert (figures["missed_commands"], figures["late"]) == (0, 0)
    assert figures["period_max_us"] == pytest.approx(500.0)
    bench.spin_until(lambda: len({stamp_of(message) for message in states}) == 201)
    assert {sample_number(stamp_of(message), T) for message in states} == set(range(201))
    loop.call("reset")
    bench.spin_until(lambda: pacing.schedule is not None)
    turn(50)
    assert loop.plant.figures()["missed_commands"] == 0


def test_executable_is_stepped_reset_and_run(
    bench: Bench,
    start_node: Callable[..., subprocess.Popen[str]],
    end_with_plant: Callable[..., str],
    short_scenario: Path,
) -> None:
    plant = start_node("plant", f"scenario:={short_scenario}", "observers:=0", "begin_at_once:=false")
    for kind in (ControllerNode, FeedforwardNode):
        partner = bench.add(kind, scenario=str(short_scenario), observers=0)
        partner.trigger_configure()
        partner.trigger_activate()
    user = bench.hold(rclpy.create_node("user", context=bench.context))
    clients = {name: user.create_client(Trigger, f"plant/{name}") for name in ("start", "step", "reset")}

    def until(name: str, said: str) -> None:
        """Ask for a service again and again until it says so: partners take their time to come up."""
        for _ in range(1000):
            future = clients[name].call_async(Trigger.Request())
            bench.spin_until(future.done)
            if said in future.result().message:
                return
            bench.spin_for(0.02)
        raise AssertionError(f"{name} never said {said}")

    for client in clients.values():
        bench.spin_until(client.service_is_ready, TIMEOUT)
    until("step", "sample 5")
    until("reset", "back before its first sample")
    until("start", "continues from")
    end_with_plant(plant, spin=lambda: bench.spin_for(0.02))


def test_services_and_topics_go_with_the_clean_up(bench: Bench) -> None:
    plant = bench.add(PlantNode)
    before = len(list(plant.services)), len(list(plant.publishers)), len(list(plant.subscriptions))
    for _ in range(2):
        plant.trigger_configure()
        assert len(list(plant.services)) == before[0] + 4
        plant.trigger_cleanup()
        assert (len(list(plant.services)), len(list(plant.publishers)), len(list(plant.subscriptions))) == before
