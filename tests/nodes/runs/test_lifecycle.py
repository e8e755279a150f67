"""Nodes as ROS 2 sees them: lifecycle, declared parameters, live gains, a trajectory from the user."""

from __future__ import annotations

import json
from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("rclpy", reason="needs ROS 2")

import rclpy
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from rclpy.lifecycle import TransitionCallbackReturn
from rclpy.parameter import Parameter
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from flexros.scenario.scenario import load_scenario
from flexros_nodes.controller.node import ControllerNode
from flexros_nodes.feedforward import FeedforwardNode
from flexros_nodes.plant.node import PlantNode
from flexros_nodes.protocol.parameters import node_parameters
from flexros_nodes.recorder import RecorderNode
from flexros_nodes.shell.node_base import FlexrosNode
from flexros_nodes.shell.prepared_run import prepared_run

pytestmark = pytest.mark.slow

MCAP_MAGIC = b"\x89MCAP0\r\n"
SUCCESS, FAILURE = TransitionCallbackReturn.SUCCESS, TransitionCallbackReturn.FAILURE
NODES = (RecorderNode, FeedforwardNode, ControllerNode, PlantNode)
Bench = Any  # the class is in conftest


@pytest.mark.parametrize("node_class", NODES)
def test_every_node_goes_through_its_lifecycle_twice(
    bench: Bench, tmp_path: Path, node_class: type[FlexrosNode]
) -> None:
    folder = {"folder": str(tmp_path / "log")} if node_class is RecorderNode else {}
    node = bench.add(node_class, **folder)
    for turn in (1, 2):
        if folder and turn == 2:
            (tmp_path / "log").rename(tmp_path / "first")
        assert node.trigger_configure() == SUCCESS
        assert node.trigger_activate() == SUCCESS
        assert node.trigger_deactivate() == SUCCESS
        assert node.trigger_cleanup() == SUCCESS
    assert node.trigger_shutdown() == SUCCESS
    assert node.report is not None
    assert node.report.exit_code == 0


@pytest.mark.parametrize("node_class", NODES)
def test_parameters_are_declared_and_described(bench: Bench, node_class: type[FlexrosNode]) -> None:
    node = bench.add(node_class)
    for name, specification in node_parameters(node.node_name).items():
        descriptor = node.describe_parameter(name)
        assert descriptor.description.startswith(specification.description)
        assert descriptor.read_only == specification.read_only
        assert bool(descriptor.floating_point_range or descriptor.integer_range) == (specification.bounds is not None)


def test_scenario_that_does_not_exist_fails_to_configure(bench: Bench) -> None:
    node = bench.add(PlantNode, scenario="nowhere")
    assert node.trigger_configure() == FAILURE
    assert node.report.exit_code == 2
    assert "unknown scenario 'nowhere'" in node.report.message


def test_gains_are_parameters_that_may_change(bench: Bench) -> None:
    node = bench.add(ControllerNode)
    node.trigger_configure()
    assert node.value("motor_2.kp") == 135000.0
    assert node.set_parameters([Parameter("motor_2.kp", value=1000.0)])[0].successful
    names = node.controller.gain_names
    assert node.controller.gains[names.index("motor_2.kp")] == 1000.0


def test_gain_given_at_the_start_replaces_that_of_the_scenario(bench: Bench) -> None:
    node = bench.add(ControllerNode, **{"motor_1.kd": 5.0})
    node.trigger_configure()
    assert node.controller.gains[node.controller.gain_names.index("motor_1.kd")] == 5.0


def test_controller_follows_a_trajectory_of_the_user(bench: Bench) -> None:
    controller = bench.add(ControllerNode, observers=0)
    user = rclpy.create_node("user", context=bench.context)
    bench.nodes.append(user)
    bench.executor.add_node(user)
    answers: list[JointState] = []
    user.create_subscription(JointState, "joint_reference", answers.append, 10)
    user.create_subscription(JointState, "joint_commands", lambda _: None, 10)
    states = user.create_publisher(JointState, "joint_states", 10)
    trajectories = user.create_publisher(JointTrajectory, "joint_trajectory", 10)
    controller.trigger_configure()
    controller.trigger_activate()
    trajectory = JointTrajectory(joint_names=["motor_2", "motor_1"])
    trajectory.points = [JointTrajectoryPoint(positions=[0.2, 0.1])]
    state = JointState(name=["motor_1", "motor_2"], position=[0.0, 0.0])
    state.header.stamp.sec = 1
    bench.spin_until(lambda: trajectories.get_subscription_count() > 0 and states.get_subscription_count() > 0)
    states.publish(state)  # held until there is a reference
    trajectories.publish(trajectory)
    bench.spin_until(lambda: bool(answers))
    assert list(answers[0].position) == [0.1, 0.2]
    assert answers[0].header.stamp.sec == 1


def test_measurement_that_is_not_a_number_ends_the_controller(bench: Bench) -> None:
    controller = bench.add(ControllerNode, observers=0)
    user = rclpy.create_node("user", context=bench.context)
    bench.nodes.append(user)
    bench.executor.add_node(user)
    user.create_subscription(JointState, "joint_commands", lambda _: None, 10)
    states = user.create_publisher(JointState, "joint_states", 10)
    controller.trigger_configure()
    controller.trigger_activate()
    state = JointState(name=["motor_1", "motor_2"], position=[0.0, float("nan")])
    state.header.stamp.sec = 1
    bench.spin_until(lambda: states.get_subscription_count() > 0)
    states.publish(state)
    bench.spin_until(lambda: controller.report is not None)
    assert controller.report.exit_code == 3
    assert "the measurement at stamp 1.0000 s is rejected: its position is [0.0, nan]" in controller.report.message


def test_internal_error_of_a_node_is_reported(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    node = bench.add(FeedforwardNode)
    monkeypatch.setattr(node, "configure", lambda: {}["nothing"])
    assert node.trigger_configure() == FAILURE
    assert node.report.exit_code == 70
    assert node.report.message == "node feedforward has an internal error: KeyError: 'nothing'; please report it"


@pytest.mark.parametrize("node_class", [FeedforwardNode, ControllerNode, PlantNode])
def test_node_activated_again_restarts(bench: Bench, node_class: type[FlexrosNode]) -> None:
    node = bench.add(node_class)
    node.trigger_configure()
    for _ in range(2):
        assert node.trigger_activate() == SUCCESS
        assert node.active
        assert node.trigger_deactivate() == SUCCESS
    assert node.report is None


def test_loop_runs_from_the_first_sample_after_a_second_activation(bench: Bench) -> None:
    nodes = [bench.add(node_class, observers=0) for node_class in (FeedforwardNode, ControllerNode, PlantNode)]
    plant = nodes[-1]
    for node in nodes:
        node.trigger_configure()
    for turn in (1, 2):
        for node in nodes:
            assert node.trigger_activate() == SUCCESS
        bench.spin_until(lambda: plant.report is not None or (turn == 1 and plant.stamp > 1_050_000_000))  # noqa: B023
        for node in nodes:
            node.trigger_deactivate()
        bench.spin_for(0.2)  # what is still under way is heard by nobody
    assert plant.report.exit_code == 0
    assert plant.report.figures["samples"] == 762


def test_recorder_refuses_to_go_on_with_a_closed_log(bench: Bench, tmp_path: Path) -> None:
    recorder = bench.add(RecorderNode, folder=str(tmp_path / "log"))
    recorder.trigger_configure()
    assert recorder.trigger_activate() == SUCCESS
    assert recorder.trigger_deactivate() == SUCCESS
    assert recorder.trigger_activate() == FAILURE
    assert recorder.refusal() == (
        f"the log {tmp_path / 'log'} is closed; clean up the node and configure it with another folder"
    )
    assert recorder.trigger_cleanup() == SUCCESS
    assert recorder.set_parameters([Parameter("folder", value=str(tmp_path / "second"))])[0].successful
    assert recorder.trigger_configure() == SUCCESS
    assert recorder.trigger_activate() == SUCCESS
    assert (tmp_path / "second" / "second_0.mcap").is_file()


def test_log_of_a_recorder_destroyed_while_active_is_closed(bench: Bench, tmp_path: Path) -> None:
    recorder = bench.add(RecorderNode, folder=str(tmp_path / "log"))
    recorder.trigger_configure()
    recorder.trigger_activate()
    bench.executor.remove_node(recorder)
    bench.nodes.remove(recorder)
    recorder.destroy_node()
    assert (tmp_path / "log" / "log_0.mcap").read_bytes().endswith(MCAP_MAGIC)


@pytest.mark.parametrize("end", ["trigger_cleanup", "trigger_shutdown"])
def test_log_of_a_run_that_never_began_is_closed(bench: Bench, tmp_path: Path, end: str) -> None:
    recorder = bench.add(RecorderNode, folder=str(tmp_path / "log"))
    recorder.trigger_configure()
    getattr(recorder, end)()
    content = (tmp_path / "log" / "log_0.mcap").read_bytes()
    assert content.endswith(MCAP_MAGIC)
    assert len(content) > 2 * len(MCAP_MAGIC)


def test_failed_configuration_leaves_no_publishers(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    node = bench.add(ControllerNode)
    publishers = len(list(node.publishers))
    monkeypatch.setattr(node, "listen", lambda *_: {}["nothing"])
    assert node.trigger_configure() == FAILURE
    assert len(list(node.publishers)) == publishers


@pytest.mark.parametrize("node_class", NODES)
def test_foreign_parameters_do_no_harm_before_the_configuration(bench: Bench, node_class: type[FlexrosNode]) -> None:
    node = bench.add(node_class)
    assert node.set_parameters([Parameter("use_sim_time", value=False)])[0].successful


def test_gain_is_applied_only_when_the_whole_set_is_accepted(bench: Bench) -> None:
    node = bench.add(ControllerNode)
    node.trigger_configure()
    before = node.controller.gains
    result = node.set_parameters_atomically(
        [Parameter("motor_1.kp", value=1.0), Parameter("motor_1.kd", value=float("nan"))]
    )
    assert not result.successful
    assert node.controller.gains.tolist() == before.tolist()


def test_scenario_edited_between_cleanup_and_configure_is_reloaded(bench: Bench, tmp_path: Path) -> None:
    path = tmp_path / "own.yaml"
    settings = load_scenario("circle_dae").settings()
    path.write_text(json.dumps(settings))
    node = bench.add(ControllerNode, scenario=str(path))
    node.trigger_configure()
    settings["controller"]["kp"] = 77.0
    path.write_text(json.dumps(settings))
    node.trigger_cleanup()
    assert node.trigger_configure() == SUCCESS
    assert node.value("motor_1.kp") == 77.0


def test_edited_robot_is_reloaded(bench: Bench, tmp_path: Path) -> None:
    robot = tmp_path / "robot.yaml"
    robot.write_text(files("flexros.robot").joinpath("library/two_mass.yaml").read_text())
    path = tmp_path / "own.yaml"
    path.write_text(json.dumps({**load_scenario("two_mass_step").settings(), "robot": str(robot)}))
    first = prepared_run(str(path))
    assert prepared_run(str(path)) is first
    robot.write_text(robot.read_text().replace("value: 1e-3", "value: 2e-3", 1))
    assert prepared_run(str(path)).nominal.sample_time == 0.002


def test_plant_without_partners_reports_what_is_missing(bench: Bench) -> None:
    plant = bench.add(PlantNode, start_timeout=0.2, observers=3)
    plant.trigger_configure()
    plant.trigger_activate()
    bench.spin_until(lambda: plant.report is not None)
    assert plant.report.exit_code == 3
    assert plant.report.message == (
        "no partners within 0.2 s: joint_states has 0 subscriptions, needed are a controller and 3 recorders; start "
        "them with the same ROS_DOMAIN_ID"
    )


def test_gain_that_is_not_a_number_at_the_start_is_bad_input(bench: Bench) -> None:
    node = bench.add(ControllerNode, **{"motor_1.kp": float("nan")})
    assert node.trigger_configure() == FAILURE
    assert node.report.exit_code == 2
    assert "parameter motor_1.kp of node controller is nan, allowed is a finite number" in node.report.message


def test_transition_asked_for_twice_is_refused_and_the_node_lives_on(bench: Bench) -> None:
    node = bench.add(ControllerNode)
    client = bench.nodes[0].create_client(ChangeState, "/controller/change_state")
    bench.spin_until(client.service_is_ready)
    answers = []
    for _ in range(2):
        request = ChangeState.Request()
        request.transition.id = Transition.TRANSITION_CONFIGURE
        future = client.call_async(request)
        bench.spin_until(future.done)
        answers.append(future.result().success)
    assert answers == [True, False]
    assert node.report is None
