"""Nodes as ROS 2 sees them: lifecycle, declared parameters, live gains, a trajectory from the user."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from time import monotonic
from typing import Any

import pytest

pytest.importorskip("rclpy", reason="needs ROS 2")

import rclpy
from rclpy.context import Context
from rclpy.executors import Executor
from rclpy.lifecycle import TransitionCallbackReturn
from rclpy.parameter import Parameter
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from flexros_nodes.controller import ControllerNode
from flexros_nodes.feedforward import FeedforwardNode
from flexros_nodes.node_base import FlexrosNode
from flexros_nodes.parameters import node_parameters
from flexros_nodes.plant import PlantNode
from flexros_nodes.recorder import RecorderNode
from flexros_nodes.spinning import make_executor

SUCCESS, FAILURE = TransitionCallbackReturn.SUCCESS, TransitionCallbackReturn.FAILURE
NODES = (RecorderNode, FeedforwardNode, ControllerNode, PlantNode)


class Bench:
    """Nodes in a context of their own, with an executor to spin them."""

    def __init__(self, context: Context, executor: Executor) -> None:
        self.context = context
        self.executor = executor
        self.nodes: list[Any] = []

    def add(self, node_class: type[FlexrosNode], **values: Any) -> Any:
        node = node_class(context=self.context, values={"scenario": "circle_dae", **values})
        self.nodes.append(node)
        self.executor.add_node(node)
        return node

    def spin_until(self, condition: Callable[[], bool], timeout: float = 20.0) -> None:
        deadline = monotonic() + timeout
        while not condition():
            assert monotonic() < deadline, "the condition did not come true"
            self.executor.spin_once(timeout_sec=0.02)


@pytest.fixture
def bench(ros_domain: int) -> Iterator[Bench]:
    context = Context()
    rclpy.init(context=context, args=[], domain_id=ros_domain)
    bench = Bench(context, make_executor(context))
    yield bench
    bench.executor.shutdown()
    for node in bench.nodes:
        node.destroy_node()
    rclpy.try_shutdown(context=context)


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
        assert descriptor.read_only
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
    names = node._controller.law.gain_names(2)
    assert node._controller.gains[names.index("motor_2.kp")] == 1000.0


def test_gain_given_at_the_start_replaces_that_of_the_scenario(bench: Bench) -> None:
    node = bench.add(ControllerNode, **{"motor_1.kd": 5.0})
    node.trigger_configure()
    assert node._controller.gains[node._controller.law.gain_names(2).index("motor_1.kd")] == 5.0


def test_gain_that_is_not_a_number_is_refused(bench: Bench) -> None:
    node = bench.add(ControllerNode)
    node.trigger_configure()
    result = node.set_parameters([Parameter("motor_1.kp", value=float("nan"))])[0]
    assert not result.successful
    assert "parameter motor_1.kp of node controller is nan, allowed is a finite number" in result.reason


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
    assert "the measurement at stamp 1.0000 s is refused: its position is [0.0, nan]" in controller.report.message


def test_fault_in_a_node_is_told_as_such(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    node = bench.add(FeedforwardNode)
    monkeypatch.setattr(node, "configure", lambda: {}["nothing"])
    assert node.trigger_configure() == FAILURE
    assert node.report.exit_code == 70
    assert node.report.message == "node feedforward has a fault: KeyError: 'nothing'; please report it"
