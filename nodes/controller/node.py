"""Controller node: answers each measurement with the command of the control law of the scenario."""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING

from std_msgs.msg import Header

from flexros.errors import FlexrosError, RunError
from flexros.logs.cdr_cursor import MessageError
from flexros.logs.messages.joint_state import JointStateTemplate, JointStateView
from flexros.logs.messages.joint_trajectory import read_joint_trajectory
from flexros.logs.stamps import NANOSECONDS, sample_number
from flexros_nodes.controller.follow_trajectory import FollowTrajectory, installed_action
from flexros_nodes.protocol.loop.lockstep import Arrival, ControllerLockStep
from flexros_nodes.protocol.loop.message_loss import MessageLoss
from flexros_nodes.protocol.own_joints import OwnJoints
from flexros_nodes.protocol.parameters import gain_parameters
from flexros_nodes.protocol.reference.link_columns import names_with_links
from flexros_nodes.protocol.reference.reference_buffer import ReferenceBuffer
from flexros_nodes.protocol.reference.trajectory_request import in_joint_order
from flexros_nodes.protocol.sensor_messages import SensorReader, sensor_topics
from flexros_nodes.shell.node_base import FlexrosNode
from flexros_nodes.shell.partners import WATCH_PERIOD, Partners, strangers_message
from flexros_nodes.shell.prepared_run import prepared_run

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from flexros.logs.messages.joint_trajectory import JointTrajectoryChunk
    from flexros_nodes.protocol.parameters import Value

STOP_TIME = 0.2
"""Time in which a cancelled motion comes to rest [s], chosen."""

REJECTION_PERIOD = 1.0
"""Shortest time between two logged rejections of trajectories [s], chosen: a flood of them must not fill the log."""

READ_BUDGET = 10
"""Trajectories that are decoded on arrival after a long time without any, chosen."""

READS_PER_SAMPLE = 0.05
"""Trajectories decoded per sample in a flood of them, chosen."""


class ControllerNode(FlexrosNode):
    """Feedback controller of a scenario: a function of stamp, measurement, reference and its own state.

    It answers sample k once it holds the reference of k, repeats its last reply for a repeated stamp, and drops older
    stamps. It never reads a clock.
    """

    node_name = "controller"
    _gain_names: tuple[str, ...] = ()
    follower: FollowTrajectory | None = None

    def configure(self) -> None:
        """Prepare the control law, publishers and subscriptions; declare the gains."""
        self.claim("joint_commands")
        run = prepared_run(self.value("scenario"))
        self._names = run.nominal.joint_names
        self._n_motors = len(self._names)
        self.controller = run.controller()
        self._follows_links = run.loop_context.link_motion
        self._links_as_motors = self.controller.law.links_as_motors
        self._chunk_names = names_with_links(self._names) if self._follows_links else self._names
        size = run.sensor_timing.size if self.controller.uses_further else 0
        sensors = sensor_topics(run.nominal, run.sensor_timing) if size else ()
        self._sensors = SensorReader(sensors, size)
        self._unused = [0.0] * (run.sensor_timing.size - size)
        self._declare_gains()
        self._sample_time = run.sample_time
        self._view = JointStateView(self._names)
        self._own_joints = OwnJoints(self._names)
        self._partners = Partners(self)
        self._command_message = JointStateTemplate(self._names, effort=True)
        self._reference_message = JointStateTemplate(self._names, position=True, velocity=True, effort=True)
        self._confirmation = Header()
        self._begin()
        self._commands = self.announce("joint_commands")
        self._references = self.announce("joint_reference")
        self._received = self.announce("reference_received")
        for sensor in sensors:
            self.listen(sensor.topic, partial(self._on_sensor, sensor.topic))
        self.listen("joint_states", self._on_state)
        self.listen("joint_reference_ahead", self._on_chunk)
        self.listen("joint_trajectory", self._on_trajectory)
        if (action := installed_action()) is not None:
            self.follower = FollowTrajectory(self, self._names, action)
            self.on_close(self._close_follower)

    def _close_follower(self) -> None:
        if self.follower is not None:
            self.follower.close()
            self.follower = None

    def _begin(self) -> None:
        """Return to the state before the first sample."""
        if self.follower is not None:
            self.follower.abort("the loop restarts")
        self.controller.reset()
        self._sensors.begin()
        self.buffer = ReferenceBuffer(
            self._n_motors,
            self._sample_time,
            link_motion=self._follows_links,
            links_as_motors=self._links_as_motors,
        )
        self._lockstep = ControllerLockStep(self._sample_time)
        self._loss = MessageLoss(self.value("drop_fraction"), self.value("drop_seed"))
        self._drops: Callable[[], bool] | None = self._loss.drops if self.value("drop_fraction") else None
        self._pending: tuple[float, ...] | None = None
        self._further: list[float] | None = None
        self._reply: tuple[bytes, bytes] | None = None
        self._partners_found = False
        self._answered = self._waits = self._rejected = 0
        self._read_budget = float(READ_BUDGET)
        self._newest_trajectory: bytes | None = None

    def start(self) -> None:
        """Begin at the first sample, also when the node has worked before."""
        self._begin()
        self.every(WATCH_PERIOD, self._refuse_strangers)

    def stop(self) -> None:
        """Abort the goal that is followed."""
        if self.follower is not None:
            self.follower.abort("the controller has stopped")

    def _declare_gains(self) -> None:
        gains = self.controller.gains
        self.undeclare(name for name in self._gain_names if self.has_parameter(name))  # the scenario may have changed
        self._gain_names = self.controller.gain_names
        self.declare(gain_parameters(self.controller.law, self._gain_names, gains))
        self._set_gains({name: self.value(name) for name in self._gain_names if self.has_parameter(name)})

    def parameters_changed(self, values: Mapping[str, Value]) -> None:
        """Apply changed gains from the next sample on, and log it."""
        if gains := {name: values[name] for name in self._gain_names if name in values}:
            self._set_gains(gains)
            what = ", ".join(f"{name} = {value!r}" for name, value in gains.items())
            first = f"the sample after stamp {self.stamp / NANOSECONDS:.4f} s" if self._answered else "the first sample"
            self.get_logger().info(f"{what} from {first} on")

    def _set_gains(self, values: Mapping[str, Value]) -> None:
        gains = self.controller.gains
        for i, name in enumerate(self._gain_names):
            gains[i] = values.get(name, gains[i])
        self.controller.gains = gains

    def figures(self) -> dict[str, float]:
        """Return counts of answered, repeated and lost states."""
        return {
            "answered": self._answered,
            "repeated_states": self._lockstep.repeated,
            "old_states": self._lockstep.old,
            "missed_states": self._lockstep.missed,
            "waits_for_reference": self._waits,
            "ignored_chunks": self.buffer.ignored,
            "refused_trajectories": self._rejected,
            "dropped_on_purpose": self._loss.dropped,
        }

    # Measurement -> command.

    def _on_state(self, message: bytes) -> None:
        if self._drops is not None and self._drops():
            return
        if not self._partners_found and not self.find_partners():
            return
        try:
            if not self._own_joints.are_in(message):
                return
            sample = self._view.unpack(message)
        except FlexrosError as error:
            raise RunError(f"a measurement on joint_states is rejected: {error}") from error
        arrival = self._lockstep.arrival(sample.stamp_ns)
        if arrival is Arrival.NEW:
            if sample.position is None or not math.isfinite(sum(sample.position)):
                raise RunError(
                    f"the measurement at stamp {sample.stamp_ns / NANOSECONDS:.4f} s is rejected: its position is "
                    f"{'empty' if sample.position is None else list(sample.position)}, required is one finite "
                    f"number for each of {', '.join(self._names)}"
                )
            self._pending, self._further = sample.position, None
            self._answer()
        elif arrival is Arrival.REPEATED and self._pending is None and self._reply is not None:
            self.publish_reply(*self._reply)
        elif arrival is Arrival.RESTARTED:
            self.get_logger().info("the plant has restarted, and so does the controller")
            self._begin()
            self._on_state(message)

    def _on_sensor(self, name: str, message: bytes) -> None:
        if self._drops is not None and self._drops():
            return
        self._sensors.take(name, message)
        if self._pending is not None:
            self._answer()

    def find_partners(self) -> bool:
        """Return whether plant and recorders would receive a reply; until then the plant repeats its first state."""
        observers = self.value("observers")
        self._partners_found = (
            self._commands.get_subscription_count() > observers
            and self._references.get_subscription_count() >= observers
            and not self._partners.surplus()
        )
        return self._partners_found

    def _refuse_strangers(self) -> None:
        """Abort where a second plant, controller or reference stream has joined since the partners were found."""
        if self._partners_found and (surplus := self._partners.surplus()):
            raise RunError(strangers_message(surplus))

    def _answer(self) -> None:
        """Answer the newest measurement if its reference is available."""
        if self._newest_trajectory is not None and self._read_budget >= 1.0:
            self._read_trajectory(self._newest_trajectory)
        position = self._pending
        if position is None:
            return
        stamp = self._lockstep.last
        further = self._further
        if further is None:
            further = self._further = self._sensors.values(sample_number(stamp, self._sample_time), stamp)
        if further is None:
            return  # the messages of the other sensors are on their way
        reference = self.buffer.take(stamp, position)
        if reference is None:
            self._waits += 1
            return
        command = self.controller.step([*position, *further, *self._unused], reference)
        self._pending = None
        self._read_budget = min(self._read_budget + READS_PER_SAMPLE, READ_BUDGET)
        self.stamp = stamp
        self._answered += 1
        n = self._n_motors
        values = reference.tolist()
        self._reply = (
            self._command_message.fill(stamp, effort=command),
            self._reference_message.fill(stamp, values[:n], values[n : 2 * n], values[2 * n : 3 * n]),
        )
        self.publish_reply(*self._reply)
        if self.follower is not None:
            self.follower.sampled(stamp, self.buffer.trajectory_end, reference, position)

    def publish_reply(self, command: bytes, reference: bytes) -> None:
        """Publish the command of a sample and the reference it used."""
        self._commands.publish(command)
        self._references.publish(reference)

    # Reference.

    def _on_chunk(self, message: bytes) -> None:
        if self._drops is not None and self._drops():
            return
        try:
            stamp = self.buffer.append_message(message, self._chunk_names)
        except MessageError as error:
            raise RunError(f"a message on joint_reference_ahead is rejected: {error}") from error
        self._answer()
        self._confirmation.stamp.sec, self._confirmation.stamp.nanosec = divmod(stamp, NANOSECONDS)
        self._received.publish(self._confirmation)

    def _on_trajectory(self, message: bytes) -> None:
        """Decode a trajectory; in a flood of them only the newest at intervals."""
        if self._read_budget >= 1.0:
            self._read_trajectory(message)
        else:
            self._newest_trajectory = message

    def _read_trajectory(self, message: bytes) -> None:
        """Follow a trajectory from the next sample on; an invalid one must not end the loop."""
        self._read_budget -= 1.0
        self._newest_trajectory = None
        try:
            trajectory = in_joint_order(read_joint_trajectory(message), self._names)
            self.check_trajectory(trajectory)
        except FlexrosError as error:
            self._rejected += 1
            self.get_logger().warning(
                f"a trajectory on joint_trajectory is rejected: {error}; the reference is unchanged",
                throttle_duration_sec=REJECTION_PERIOD,
            )
            return
        if self.follower is not None:
            self.follower.abort("replaced by a trajectory on joint_trajectory")
        self.follow(trajectory)

    def check_trajectory(self, trajectory: JointTrajectoryChunk) -> None:
        """Raise RejectedTrajectoryError where `follow` would."""
        self.buffer.check(trajectory, self.value("position_limit"))

    def follow(self, trajectory: JointTrajectoryChunk) -> None:
        """Follow a trajectory from the next sample on.

        Args:
            trajectory: Points, joints in the order of the motors.

        Raises:
            RejectedTrajectoryError: The trajectory is invalid; the reference is unchanged.
        """
        self.buffer.replace(trajectory, self.value("position_limit"))
        self._answer()

    def come_to_rest(self) -> None:
        """Bring the reference to rest with constant deceleration."""
        self.buffer.come_to_rest(STOP_TIME)
