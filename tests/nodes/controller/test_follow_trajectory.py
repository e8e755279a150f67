"""The action FollowJointTrajectory: with a stand-in for control_msgs, which pip does not have, and over a real action.

The stand-in has the fields of the type. The second part sends goals over DDS with another action type, from test_msgs.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("rclpy", reason="needs ROS 2")

import rclpy
from builtin_interfaces.msg import Duration
from rclpy.action import ActionClient, CancelResponse, GoalResponse
from std_msgs.msg import Header
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from flexros.errors import RunError
from flexros_nodes.controller import node as controller_module
from flexros_nodes.controller.follow_trajectory import FollowTrajectory, SampledActionServer, installed_action
from flexros_nodes.controller.node import ControllerNode
from flexros_nodes.feedforward import FeedforwardNode
from tests.nodes.loop_on_bench import Loop

pytestmark = pytest.mark.slow

Bench = Any  # the class is in conftest
NAMES = ["motor_2", "motor_1"]
SUCCEEDED, CANCELED, ABORTED = 4, 5, 6


@dataclass
class Tolerance:
    name: str
    position: float = 0.0
    velocity: float = 0.0
    acceleration: float = 0.0


@dataclass
class ComponentTolerance:
    joint_name: str
    component: int = 1
    position: float = 0.0
    velocity: float = 0.0
    acceleration: float = 0.0


@dataclass
class Goal:
    trajectory: JointTrajectory = field(default_factory=JointTrajectory)
    path_tolerance: list[Tolerance] = field(default_factory=list)
    goal_tolerance: list[Tolerance] = field(default_factory=list)
    component_path_tolerance: list[ComponentTolerance] = field(default_factory=list)
    component_goal_tolerance: list[ComponentTolerance] = field(default_factory=list)
    goal_time_tolerance: Duration = field(default_factory=Duration)


@dataclass
class Result:
    error_code: int = 0
    error_string: str = ""


@dataclass
class Feedback:
    header: Header = field(default_factory=Header)
    joint_names: list[str] = field(default_factory=list)
    desired: JointTrajectoryPoint = field(default_factory=JointTrajectoryPoint)
    actual: JointTrajectoryPoint = field(default_factory=JointTrajectoryPoint)
    error: JointTrajectoryPoint = field(default_factory=JointTrajectoryPoint)


class FollowJointTrajectory:
    Goal, Result, Feedback = Goal, Result, Feedback


class Handle:
    """Goal handle of the server."""

    def __init__(self, request: Goal) -> None:
        self.request = request
        self.state = ""
        self.result: Result | None = None
        self.feedback: list[Feedback] = []

    def execute(self) -> None:
        self.state = "executing"

    def succeed(self) -> None:
        self.state = "succeeded"

    def abort(self) -> None:
        self.state = "aborted"

    def canceled(self) -> None:
        self.state = "canceled"

    def publish_feedback(self, feedback: Feedback) -> None:
        self.feedback.append(feedback)


class Server:
    """An action server without transport."""

    def __init__(self, node: Any, action: Any, name: str, **callbacks: Any) -> None:
        assert (action, name) == (FollowJointTrajectory, "~/follow_joint_trajectory")
        self.callbacks = callbacks
        self.destroyed = False

    def send(self, goal: Goal) -> Handle | None:
        if self.callbacks["goal_callback"](goal) is GoalResponse.REJECT:
            return None
        handle = Handle(goal)
        self.callbacks["handle_accepted_callback"](handle)
        return handle

    def cancel(self, handle: Handle) -> CancelResponse:
        return self.callbacks["cancel_callback"](handle)

    def notify_execute(self, handle: Handle, callback: Any) -> None:
        handle.result = callback(handle)

    def destroy(self) -> None:
        self.destroyed = True


def trajectory(*points: tuple[float, float, float], names: list[str] = NAMES) -> JointTrajectory:
    """Points of time after start [s] and positions of motor_2 and motor_1."""
    message = JointTrajectory(joint_names=names)
    for time, *positions in points:
        point = JointTrajectoryPoint(positions=positions)
        point.time_from_start.sec, point.time_from_start.nanosec = divmod(round(time * 1e9), 10**9)
        message.points.append(point)
    return message


class Robot:
    """A loop of plant and controller, paused at its first sample, and an action server to send goals to."""

    def __init__(self, bench: Bench, scenario: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(controller_module, "installed_action", lambda: FollowJointTrajectory)
        monkeypatch.setattr(
            controller_module, "FollowTrajectory", lambda *arguments: FollowTrajectory(*arguments, server=Server)
        )
        self.loop = Loop(bench, scenario, ControllerNode, begin_at_once=False)
        self.loop.bring_up()
        bench.spin_until(lambda: self.loop.sample == 0)
        self.controller = self.loop.node(ControllerNode)
        self.server: Server = self.controller.follower.server
        self.start = [float(value) for value in self.loop.plant.loop.plant.measure()][::-1]

    def run_until(self, sample: int) -> None:
        self.loop.call("start")
        self.loop.reach(sample)
        self.loop.call("pause")

    def near(self, time: float, offset: float = 0.0) -> tuple[float, float, float]:
        """A point near the initial position."""
        return time, self.start[0] + offset, self.start[1]


@pytest.fixture
def robot(bench: Bench, long_scenario: Path, monkeypatch: pytest.MonkeyPatch) -> Robot:
    return Robot(bench, long_scenario, monkeypatch)


def test_goal_is_followed_with_feedback_and_succeeds(robot: Robot) -> None:
    handle = robot.server.send(Goal(trajectory(robot.near(0.1), robot.near(0.2, 0.001))))
    assert handle is not None
    assert handle.state == "executing"
    robot.run_until(100)
    assert handle.state == "executing"
    robot.run_until(600)
    assert (handle.state, handle.result) == ("succeeded", Result())
    assert 4 <= len(handle.feedback) <= 6
    last = handle.feedback[-1]
    assert last.joint_names == ["motor_1", "motor_2"]
    assert last.desired.positions[1] == pytest.approx(robot.start[0] + 0.001)
    assert last.error.positions[1] == pytest.approx(last.desired.positions[1] - last.actual.positions[1])
    assert last.desired.time_from_start.nanosec == 200_000_000
    assert last.header.stamp.sec == 1


def test_goal_as_moveit_fills_it_is_followed(robot: Robot) -> None:
    """All joints by name, stamp 0, a frame, the present state first, velocities and accelerations, no tolerances."""
    goal = Goal(trajectory(*((0.1 * k, *robot.near(0, 5e-4 * k**2)[1:]) for k in range(3)), names=NAMES))
    goal.trajectory.header.frame_id = "base"
    for k, point in enumerate(goal.trajectory.points):
        point.velocities, point.accelerations = [0.01 * k * (2 - k), 0.0], [0.1 * (1 - k), 0.0]
    handle = robot.server.send(goal)
    assert handle is not None
    robot.run_until(600)
    assert (handle.state, handle.result) == ("succeeded", Result())
    assert robot.controller.buffer.current[:2].tolist() == pytest.approx([robot.start[1], robot.start[0] + 0.002])


def test_goal_that_leaves_its_path_is_aborted_and_the_robot_comes_to_rest(robot: Robot) -> None:
    goal = Goal(trajectory(robot.near(0.1, 0.5), robot.near(0.2, 0.5)), path_tolerance=[Tolerance("motor_2", 1e-3)])
    handle = robot.server.send(goal)
    assert handle is not None
    robot.run_until(700)
    assert handle.state == "aborted"
    assert handle.result is not None
    assert handle.result.error_code == -4
    assert handle.result.error_string.endswith("allowed is 0.001; the robot comes to rest")
    reference = robot.controller.buffer.current
    assert reference is not None
    assert reference[2:4].tolist() == [0.0, 0.0]
    assert abs(reference[1] - robot.start[0] - 0.5) > 1e-3


def test_goal_whose_end_is_not_reached_in_time_is_aborted(robot: Robot) -> None:
    goal = Goal(
        trajectory(robot.near(0.05, 0.2)),
        goal_tolerance=[Tolerance("motor_2", 1e-12)],
        goal_time_tolerance=Duration(nanosec=50_000_000),
    )
    handle = robot.server.send(goal)
    assert handle is not None
    robot.run_until(400)
    assert handle.state == "aborted"
    assert handle.result is not None
    assert handle.result.error_code == -5


def test_cancelled_goal_comes_to_rest(robot: Robot) -> None:
    handle = robot.server.send(Goal(trajectory(robot.near(0.0), robot.near(1.0, 0.1))))
    assert handle is not None
    robot.run_until(200)
    assert robot.server.cancel(handle) is CancelResponse.ACCEPT
    assert handle.state == "canceled"
    at = robot.controller.buffer.current[1]
    robot.run_until(1000)
    end = robot.controller.buffer.current
    assert end[3] == 0.0
    assert end[1] == pytest.approx(at + 0.1 * 0.1, abs=1e-4)  # 0.1 rad/s on average half as fast for 0.2 s
    assert robot.server.cancel(handle) is CancelResponse.REJECT


def test_new_goal_takes_the_place_of_the_one_before(robot: Robot) -> None:
    first = robot.server.send(Goal(trajectory(robot.near(10.0, 0.1))))
    second = robot.server.send(Goal(trajectory(robot.near(0.1))))
    assert first is not None
    assert second is not None
    assert first.state == "aborted"
    assert first.result == Result(-1, "replaced by another goal")
    robot.run_until(300)
    assert second.state == "succeeded"


def test_trajectory_on_the_topic_takes_the_place_of_a_goal(robot: Robot) -> None:
    handle = robot.server.send(Goal(trajectory(robot.near(10.0, 0.1))))
    assert handle is not None
    publisher = robot.loop.user.create_publisher(JointTrajectory, "joint_trajectory", 10)
    robot.loop.bench.spin_until(lambda: publisher.get_subscription_count() > 0)
    publisher.publish(trajectory(robot.near(0.1)))
    robot.loop.bench.spin_until(lambda: handle.state == "aborted")
    assert handle.result == Result(-1, "replaced by a trajectory on joint_trajectory")


@pytest.mark.parametrize("transition", ["trigger_deactivate", "trigger_shutdown"])
def test_controller_that_stops_aborts_its_goal(robot: Robot, transition: str) -> None:
    handle = robot.server.send(Goal(trajectory(robot.near(10.0))))
    assert handle is not None
    getattr(robot.controller, transition)()
    assert handle.result == Result(-1, "the controller has stopped")
    assert robot.server.send(Goal(trajectory(robot.near(10.0)))) is None


def test_goal_that_is_late_on_acceptance_is_aborted(robot: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    robot.server.send(Goal(trajectory(robot.near(0.001))))
    robot.run_until(50)
    monkeypatch.setattr(robot.controller, "check_trajectory", lambda _: None)
    goal = Goal(trajectory(robot.near(0.001)))
    goal.trajectory.header.stamp.sec = 1
    handle = robot.server.send(goal)
    assert handle is not None
    assert handle.state == "aborted"
    assert handle.result is not None
    assert handle.result.error_code == -3


def test_controller_that_fails_at_a_goal_ends_with_its_reason(robot: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(_: Any) -> None:
        raise RunError("the controller has had enough")

    monkeypatch.setattr(robot.controller, "follow", fail)
    handle = robot.server.send(Goal(trajectory(robot.near(0.1))))
    assert (robot.controller.report.exit_code, robot.controller.report.message) == (3, "the controller has had enough")
    assert handle is not None
    assert handle.result == Result(-1, "the controller has stopped")


def test_action_server_goes_with_the_clean_up(robot: Robot) -> None:
    robot.controller.trigger_deactivate()
    robot.controller.trigger_cleanup()
    assert robot.server.destroyed


@pytest.mark.parametrize(
    "goal",
    [
        Goal(),
        Goal(trajectory((0.1, 0.0, 0.0), names=["motor_1", "wrist"])),
        Goal(trajectory((0.1, 0.0, float("nan")))),
        Goal(trajectory((0.1, 0.0, 0.0)), path_tolerance=[Tolerance("wrist", 0.1)]),
        Goal(trajectory((0.1, 0.0, 1e4))),
        Goal(trajectory((0.1, 0.0, 0.0)), component_path_tolerance=[ComponentTolerance("motor_1", position=0.1)]),
        Goal(trajectory((0.1, 0.0, 0.0)), component_goal_tolerance=[ComponentTolerance("motor_1", position=0.1)]),
    ],
    ids=["empty", "joints", "nan", "tolerance", "limit", "component of the path", "component of the goal"],
)
def test_goal_that_cannot_be_followed_is_rejected(robot: Robot, goal: Goal) -> None:
    assert robot.server.send(goal) is None
    assert robot.controller.report is None


def test_action_is_offered_where_its_type_is_installed(bench: Bench) -> None:
    node = bench.add(ControllerNode)
    node.trigger_configure()
    assert (node.follower is None) == (installed_action() is None)


# Over a real action: goals, feedback, cancelling and results take the way through DDS.


class OverFibonacci(FollowTrajectory):
    """The same server with another action: `order` is the time of the motion [ms], `sequence` the error code."""

    def read(self, goal: Any) -> Any:
        point = (goal.order * 1e-3, 0.0, 0.0)
        return super().read(Goal(trajectory(point)))

    def feedback(self, stamp: int, *_: Any) -> Any:
        return self._action.Feedback(sequence=[stamp // 10**6])

    def _end(self, *arguments: Any) -> Any:
        action, self._action = self._action, FollowJointTrajectory
        result = super()._end(*arguments)
        self._action = action
        return action.Result(sequence=[result.error_code])


@pytest.mark.parametrize("default_executor", [False, True])
def test_goals_over_dds(bench: Bench, monkeypatch: pytest.MonkeyPatch, default_executor: bool) -> None:
    action = pytest.importorskip("test_msgs.action", reason="needs an action type: test_msgs").Fibonacci
    monkeypatch.setattr(controller_module, "installed_action", lambda: action)
    monkeypatch.setattr(controller_module, "FollowTrajectory", lambda *a: OverFibonacci(*a, server=SampledActionServer))
    if default_executor:
        bench.executor.shutdown()
        bench.executor = rclpy.executors.SingleThreadedExecutor(context=bench.context)
    loop = Loop(bench, "circle_pd", FeedforwardNode, ControllerNode, begin_at_once=False)
    client = ActionClient(loop.user, action, "controller/follow_joint_trajectory")
    loop.bring_up()
    bench.spin_until(lambda: loop.sample == 0 and client.server_is_ready())
    feedback: list[Any] = []

    def send(time: int) -> Any:
        future = client.send_goal_async(action.Goal(order=time), feedback_callback=feedback.append)
        bench.spin_until(future.done)
        return future.result()

    goal = send(50)
    assert goal.accepted
    loop.call("start")
    loop.reach(150)
    loop.call("pause")
    result = goal.get_result_async()
    bench.spin_until(result.done)
    assert (result.result().status, list(result.result().result.sequence)) == (SUCCEEDED, [0])
    bench.spin_until(lambda: len(feedback) == 2)
    first, second = send(60_000), send(50_000)
    aborted = first.get_result_async()
    bench.spin_until(aborted.done)
    assert (aborted.result().status, list(aborted.result().result.sequence)) == (ABORTED, [-1])
    canceling = second.cancel_goal_async()
    canceled = second.get_result_async()
    bench.spin_until(lambda: canceling.done() and canceled.done())
    assert canceled.result().status == CANCELED
    client.destroy()
