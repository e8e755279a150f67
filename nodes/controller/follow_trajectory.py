"""Action FollowJointTrajectory of the controller, where control_msgs is installed."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.serialization import serialize_message

from flexros.errors import FlexrosError, RunError
from flexros.logs.messages.joint_trajectory import JointTrajectoryChunk, read_joint_trajectory
from flexros.logs.stamps import NANOSECONDS
from flexros_nodes.protocol.reference.trajectory_goal import (
    OUTCOME_OF_REASON,
    Outcome,
    TrajectoryGoal,
    Verdict,
    position_tolerances,
    refuse_component_tolerances,
)
from flexros_nodes.protocol.reference.trajectory_request import RejectedTrajectoryError, in_joint_order

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rclpy.action.server import ServerGoalHandle

    from flexros.arrays import FloatArray

FEEDBACK_PERIOD = 0.05
"""Simulated time between two feedback messages [s], chosen."""


def installed_action() -> Any | None:
    """Return control_msgs/action/FollowJointTrajectory; None where it is not installed."""
    try:
        from control_msgs.action import FollowJointTrajectory
    except ImportError:
        return None
    return FollowJointTrajectory


class SampledActionServer(ActionServer):
    """Action server whose goals proceed with the samples of the loop instead of a task of their own.

    The executor would poll a task that awaits the end of a motion in every turn.
    """

    def notify_execute(self, goal_handle: ServerGoalHandle, execute_callback: Any) -> None:
        """Run the callback that ends a goal; starting one runs nothing."""
        if execute_callback is not None:
            super().notify_execute(goal_handle, execute_callback)


class FollowingNode(Protocol):
    """Node that follows trajectories: the controller."""

    active: bool

    def check_trajectory(self, trajectory: JointTrajectoryChunk) -> None:
        """Raise RejectedTrajectoryError where `follow` would."""

    def follow(self, trajectory: JointTrajectoryChunk) -> None:
        """Follow a trajectory from the next sample on."""

    def come_to_rest(self) -> None:
        """Bring the reference to rest."""

    def end(self, error: FlexrosError | None = None) -> None:
        """End the node, because of an error if there is one."""

    def get_logger(self) -> Any:
        """Return the logger of the node."""


class ActiveGoal(NamedTuple):
    """Goal being followed."""

    handle: Any
    goal: TrajectoryGoal
    duration: int


class FollowTrajectory:
    """Follows the goals of `~/follow_joint_trajectory`, one at a time: a new goal replaces the previous one.

    Args:
        node: The controller node.
        names: Joint names in the order of the motors.
        action: Type of the action.
        server: Class of the action server.
    """

    def __init__(
        self, node: FollowingNode, names: Sequence[str], action: Any, server: type = SampledActionServer
    ) -> None:
        self._node = node
        self._names = tuple(names)
        self._action = action
        self._active: ActiveGoal | None = None
        self._next_feedback = 0
        self.server = server(
            node,
            action,
            "~/follow_joint_trajectory",
            execute_callback=lambda _: None,
            goal_callback=self._on_goal,
            handle_accepted_callback=self._on_accepted,
            cancel_callback=self._on_cancel,
        )

    def close(self) -> None:
        """Destroy the action server."""
        self.server.destroy()

    def read(self, goal: Any) -> tuple[JointTrajectoryChunk, TrajectoryGoal]:
        """Decode a goal message.

        Raises:
            FlexrosError: The goal is invalid.
        """
        trajectory = in_joint_order(read_joint_trajectory(serialize_message(goal.trajectory)), self._names)
        path = position_tolerances(goal.path_tolerance, self._names, "path_tolerance")
        last = position_tolerances(goal.goal_tolerance, self._names, "goal_tolerance")
        for field in ("component_path_tolerance", "component_goal_tolerance"):
            refuse_component_tolerances(getattr(goal, field, ()), field)  # before control_msgs 4.5 there are none
        time = goal.goal_time_tolerance
        return trajectory, TrajectoryGoal(self._names, path, last, time.sec + time.nanosec / NANOSECONDS)

    def _on_goal(self, goal: Any) -> GoalResponse:
        try:
            if not self._node.active:
                raise RunError("the controller is not active; activate it first")
            self._node.check_trajectory(self.read(goal)[0])
        except FlexrosError as error:
            self._node.get_logger().error(f"a goal of follow_joint_trajectory is rejected: {error}")
            return GoalResponse.REJECT
        return GoalResponse.ACCEPT

    def _on_accepted(self, handle: Any) -> None:
        self.abort("replaced by another goal")
        handle.execute()
        trajectory, goal = self.read(handle.request)
        self._active = ActiveGoal(handle, goal, int(trajectory.time_from_start[-1]))
        self._next_feedback = 0
        try:
            self._node.follow(trajectory)
        except RejectedTrajectoryError as error:  # its end may have passed since it was accepted
            self._conclude(Verdict(OUTCOME_OF_REASON[error.reason], str(error)))
        except FlexrosError as error:
            self._node.end(error)

    def _on_cancel(self, handle: Any) -> CancelResponse:
        if self._active is None or self._active.handle != handle:
            return CancelResponse.REJECT  # the goal is ending already
        self._node.come_to_rest()
        self._conclude(Verdict(Outcome.SUCCESSFUL, "canceled; the robot comes to rest"), canceled=True)
        return CancelResponse.ACCEPT

    def abort(self, reason: str) -> None:
        """Abort the active goal, if any; the caller handles the reference."""
        if self._active is not None:
            self._conclude(Verdict(Outcome.INVALID_GOAL, reason))

    def sampled(self, stamp: int, end: int, reference: FloatArray, measured: Sequence[float]) -> None:
        """Evaluate a sample of the loop, and publish feedback periodically.

        Args:
            stamp: Its stamp [ns].
            end: Stamp of the last point of the trajectory [ns].
            reference: Reference used: position (M), velocity (M), torque (M), shape (3 M,).
            measured: Measured motor positions [rad or m].
        """
        if self._active is None:
            return
        n, actual = len(self._names), np.asarray(measured)
        verdict = self._active.goal.evaluate(stamp, end, reference[:n], actual)
        if verdict is not None or stamp >= self._next_feedback:
            self._next_feedback = stamp + round(FEEDBACK_PERIOD * NANOSECONDS)
            self._active.handle.publish_feedback(self.feedback(stamp, end, reference, actual))
        if verdict is not None:
            if verdict.outcome is not Outcome.SUCCESSFUL:
                self._node.come_to_rest()
            self._conclude(verdict)

    def feedback(self, stamp: int, end: int, reference: FloatArray, measured: FloatArray) -> Any:
        """Fill a feedback message; arguments as for `sampled`."""
        message, n = self._action.Feedback(), len(self._names)
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp, NANOSECONDS)
        message.joint_names = list(self._names)
        elapsed = max(stamp - end + (self._active.duration if self._active else 0), 0)
        for point in (message.desired, message.actual, message.error):
            point.time_from_start.sec, point.time_from_start.nanosec = divmod(elapsed, NANOSECONDS)
        message.desired.positions = reference[:n].tolist()
        message.desired.velocities = reference[n : 2 * n].tolist()
        message.actual.positions = measured.tolist()
        message.error.positions = (reference[:n] - measured).tolist()
        return message

    def _conclude(self, verdict: Verdict, *, canceled: bool = False) -> None:
        active, self._active = self._active, None
        if active is not None:
            self.server.notify_execute(active.handle, partial(self._end, verdict, canceled))

    def _end(self, verdict: Verdict, canceled: bool, handle: Any) -> Any:
        """Set the final state of a goal and return its result."""
        if canceled:
            handle.canceled()
        elif verdict.outcome is Outcome.SUCCESSFUL:
            handle.succeed()
        else:
            handle.abort()
        result = self._action.Result()
        result.error_code, result.error_string = int(verdict.outcome), verdict.text
        return result
