"""Other nodes in the domain of a run: a second run, a second controller, a gripper, a plant that begins again."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from flexros.errors import InputError
from flexros.logs.messages.joint_state import JointStateTemplate
from flexros.logs.reader import read_log
from flexros.logs.stamps import START_NS
from flexros.logs.time_series import Log
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario

pytest.importorskip("rclpy", reason="needs ROS 2")

import rclpy
from rclpy.lifecycle import TransitionCallbackReturn
from rclpy.parameter import Parameter

from flexros_nodes.bringup.run import run_scenario
from flexros_nodes.controller.node import ControllerNode
from flexros_nodes.feedforward import FeedforwardNode
from flexros_nodes.plant.node import PlantNode
from flexros_nodes.recorder import RecorderNode
from flexros_nodes.shell import claims
from flexros_nodes.shell.topic_interface import message_class, qos_profile, topic
from tests.nodes.loop_on_bench import Loop

Bench = Any  # the class is in conftest
OTHER_RUN = "of another run is in ROS domain"


@pytest.fixture
def elsewhere(monkeypatch: pytest.MonkeyPatch) -> None:
    """Take the claims away, as from nodes on another machine or of the user: only the graph shows them."""
    monkeypatch.setattr(claims, "_supported", lambda _: False)


def loop_at_work(bench: Bench, scenario: Path, *nodes: type) -> Loop:
    loop = Loop(bench, scenario, *nodes, FeedforwardNode, ControllerNode)
    loop.bring_up()
    loop.reach(20)
    loop.call("pause")  # else it may be over before the other one comes
    return loop


def test_second_run_in_a_domain_is_refused_and_the_first_goes_on(
    bench: Bench, short_scenario: Path, tmp_path: Path, log_differences: Callable[[Log, Log], list[str]]
) -> None:
    loop = Loop(bench, short_scenario, RecorderNode, FeedforwardNode, ControllerNode)
    loop.node(RecorderNode).set_parameters([Parameter("folder", value=str(tmp_path / "first"))])
    loop.bring_up()
    loop.reach(20)
    loop.call("pause")
    for layout in ("composed", "processes"):
        with pytest.raises(InputError, match=OTHER_RUN):
            run_scenario("circle_pd", tmp_path / "second", layout)
        assert not (tmp_path / "second").exists()
    loop.call("start")
    loop.finish()
    direct = closed_loop(Experiment.prepare(load_scenario(str(short_scenario))))
    assert log_differences(direct, read_log(tmp_path / "first")) == []


@pytest.mark.parametrize("kind", [PlantNode, ControllerNode, FeedforwardNode])
def test_second_node_of_a_kind_is_refused(bench: Bench, short_scenario: Path, kind: type) -> None:
    bench.add(kind, scenario=str(short_scenario)).trigger_configure()
    second = bench.add(kind, scenario=str(short_scenario))
    second.trigger_configure()
    assert (second.report.exit_code, OTHER_RUN in second.report.message) == (2, True)


@pytest.mark.usefixtures("elsewhere")
@pytest.mark.parametrize(
    ("kind", "who"),
    [
        (PlantNode, "2 plants (/plant, /plant)"),
        (ControllerNode, "2 controllers (/controller, /controller)"),
        (FeedforwardNode, "2 reference streams (/feedforward, /feedforward)"),
    ],
)
def test_node_of_another_run_that_joins_ends_the_run(bench: Bench, short_scenario: Path, kind: type, who: str) -> None:
    loop = loop_at_work(bench, short_scenario)
    bench.add(kind, scenario=str(short_scenario), observers=0).trigger_configure()
    bench.spin_until(lambda: loop.plant.report is not None)
    assert loop.plant.report.exit_code == 3
    assert who in loop.plant.report.message
    bench.spin_until(lambda: loop.node(ControllerNode).report is not None)


@pytest.mark.usefixtures("elsewhere")
def test_plant_with_two_controllers_waits_and_says_so(bench: Bench, short_scenario: Path) -> None:
    second = bench.add(ControllerNode, scenario=str(short_scenario), observers=0)
    second.trigger_configure()
    loop = Loop(bench, short_scenario, FeedforwardNode, ControllerNode)
    loop.bring_up()
    bench.spin_for(0.3)
    assert loop.sample == -1
    second.trigger_cleanup()  # it leaves, and the run begins
    loop.finish()
    assert loop.plant.report.figures["samples"] == 401


def test_gripper_on_joint_states_changes_nothing(
    bench: Bench, short_scenario: Path, tmp_path: Path, log_differences: Callable[[Log, Log], list[str]]
) -> None:
    gripper = bench.hold(rclpy.create_node("gripper", context=bench.context))
    row = topic("joint_states")
    fingers = gripper.create_publisher(message_class(row.type), row.name, qos_profile(row.qos))
    message = JointStateTemplate(("finger_left", "finger_right"), position=True)
    stamps = iter(range(1_700_000_000 * 10**9, 1_700_000_100 * 10**9, 10**6))
    gripper.create_timer(1e-3, lambda: fingers.publish(message.fill(next(stamps), [0.1, 0.1])))
    loop = Loop(bench, short_scenario, RecorderNode, FeedforwardNode, ControllerNode)
    loop.node(RecorderNode).set_parameters([Parameter("folder", value=str(tmp_path / "log"))])
    loop.bring_up()
    loop.finish()
    assert next(stamps) > 1_700_000_000 * 10**9 + 2 * 10**6  # it did publish
    direct = closed_loop(Experiment.prepare(load_scenario(str(short_scenario))))
    assert log_differences(direct, read_log(tmp_path / "log")) == []


def test_plant_does_not_begin_again_beside_the_recorder_of_the_run_before(
    bench: Bench, short_scenario: Path, tmp_path: Path
) -> None:
    loop = Loop(bench, short_scenario, RecorderNode, FeedforwardNode, ControllerNode)
    recorder = loop.node(RecorderNode)
    recorder.set_parameters([Parameter("folder", value=str(tmp_path / "first"))])
    loop.bring_up()
    loop.reach(50)
    loop.call("pause")
    bench.spin_for(0.2)
    loop.plant.trigger_deactivate()
    assert loop.plant.trigger_activate() == TransitionCallbackReturn.FAILURE
    assert "a recorder is connected, whose log cannot return to the first sample" in loop.plant.refusal()
    recorder.trigger_deactivate()
    recorder.trigger_cleanup()
    recorder.set_parameters([Parameter("folder", value=str(tmp_path / "second"))])
    recorder.trigger_configure()
    recorder.trigger_activate()
    bench.spin_until(lambda: not loop.plant.refusal())
    assert loop.plant.trigger_activate() == TransitionCallbackReturn.SUCCESS
    loop.finish()
    assert read_log(tmp_path / "second").joint_states.stamp[0] == START_NS
    assert len(read_log(tmp_path / "second").joint_states.stamp) == 401


def test_recorder_refuses_a_second_run_of_any_plant(bench: Bench, short_scenario: Path, tmp_path: Path) -> None:
    recorder = bench.add(RecorderNode, scenario=str(short_scenario), folder=str(tmp_path / "log"))
    plant = bench.hold(rclpy.create_node("plant_of_the_user", context=bench.context))
    row = topic("joint_states")
    states = plant.create_publisher(message_class(row.type), row.name, qos_profile(row.qos))
    message = JointStateTemplate(("motor_1", "motor_2"), position=True)
    recorder.trigger_configure()
    recorder.trigger_activate()
    bench.spin_until(lambda: states.get_subscription_count() > 0)
    for k in (0, 0, 0, 0, 1, 2, 3, 0, 4):  # a repeated first sample is no second run
        states.publish(message.fill(START_NS + k * 500_000, [0.0, 0.0]))
    bench.spin_until(lambda: recorder.figures()["joint_states.messages"] == 5)
    assert recorder.report is None
    for _ in range(3):
        states.publish(message.fill(START_NS, [0.0, 0.0]))
    bench.spin_until(lambda: recorder.report is not None)
    assert recorder.report.exit_code == 3
    assert "a log holds one run" in recorder.report.message
    assert len(read_log(tmp_path / "log").joint_states.stamp) == 5
