"""Messages of the plant: state, tool pose and clock of one sample."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosgraph_msgs.msg import Clock

from flexros.logs.cdr_cursor import CdrCursor
from flexros.logs.messages.joint_state import JointStateTemplate
from flexros.logs.messages.pose_stamped import PoseStampedTemplate
from flexros.logs.stamps import NANOSECONDS, stamp_ns, stamp_of
from flexros.logs.time_series import BASE_FRAME
from flexros_nodes.protocol.recorder.recorder_window import RecorderWindow
from flexros_nodes.protocol.sensor_messages import SensorWriter, sensor_topics
from flexros_nodes.shell.topic_interface import period, sampled_topics, topic

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.scenario.experiment import Experiment
    from flexros_nodes.shell.node_base import FlexrosNode

OWN_TOPICS = ("joint_states", "tool_pose")
"""Recorded topics of every plant; those of further sensors follow."""


class PlantMessages:
    """Fills the messages of one sample, and publishes them once or repeatedly.

    Args:
        node: The plant node.
        run: The run.

    Attributes:
        own_topics: Recorded topics of the plant in this run.
    """

    def __init__(self, node: FlexrosNode, run: Experiment) -> None:
        self._node = node
        self._sample_time = sample_time = run.sample_time
        sensors = sensor_topics(run.plant, run.sensor_timing)
        self.own_topics = (*OWN_TOPICS, *(sensor.topic for sensor in sensors))
        self._sensors = {sensor.topic: node.announce(sensor.topic) for sensor in sensors}
        self._sensor_writer = SensorWriter(sensors)
        self._sensor_messages: dict[str, bytes] = {}
        self._states = node.announce("joint_states")
        self._poses = node.announce("tool_pose")
        self._clock = node.announce("clock")
        self._clock_every = max(round(period("clock") / sample_time), 1)
        self._state_template = JointStateTemplate(run.nominal.joint_names, position=True)
        self._pose_template = PoseStampedTemplate(BASE_FRAME)
        self._clock_message: Clock | None = None

    def listeners(self) -> int:
        """Count the subscriptions to joint_states."""
        return int(self._states.get_subscription_count())

    def have_partners(self, observers: int) -> bool:
        """Return whether a controller and this number of recorders are connected."""
        connected = self.listeners() > observers and self._poses.get_subscription_count() >= observers
        return connected and self.is_published("joint_commands")

    def is_published(self, name: str) -> bool:
        """Return whether a topic of the contract has a publisher."""
        return self._publishers(name) > 0

    def controllers(self) -> int:
        """Count the publishers of joint_commands."""
        return self._publishers("joint_commands")

    def _publishers(self, name: str) -> int:
        return int(self._node.count_publishers(self._node.resolve_topic_name(topic(name).name)))

    def fill(self, k: int, position: FloatArray, pose: FloatArray, further: FloatArray) -> int:
        """Fill the messages of a sample.

        Args:
            k: Sample.
            position: Measured motor positions [rad or m], shape (M,).
            pose: Tool pose x, y, z [m], quaternion x, y, z, w, shape (7,).
            further: Values of the further sensors, shape (n_further,).

        Returns:
            The stamp [ns].
        """
        stamp = stamp_ns(k, self._sample_time)
        values = pose.tolist()
        self._state = self._state_template.fill(stamp, position=position)
        self._pose = self._pose_template.fill(stamp, values[:3], values[3:])
        if self._sensors:
            self._sensor_messages = self._sensor_writer.fill(k, stamp, further)
        self._clock_message = None
        if k % self._clock_every == 0:
            self._clock_message = _clock_at(stamp)
        return stamp

    def publish(self) -> None:
        """Publish the messages of the sample, also repeatedly."""
        for name, message in self._sensor_messages.items():
            self._sensors[name].publish(message)
        self._states.publish(self._state)
        self._poses.publish(self._pose)
        if self._clock_message is not None:
            self._clock.publish(self._clock_message)

    def publish_time(self, stamp: int) -> None:
        """Publish the simulated time [ns] beside the samples, for whom missed the last ones: only the newest counts."""
        self._clock.publish(_clock_at(stamp))


def _clock_at(stamp: int) -> Clock:
    message = Clock()
    message.clock.sec, message.clock.nanosec = divmod(stamp, NANOSECONDS)
    return message


def recorder_window(samples: int, sample_time: float, real_time: bool, own: Sequence[str]) -> RecorderWindow:
    """Create the flow control between plant and recorder.

    Args:
        samples: Samples that the loop may run ahead of the recorder; 0 disables all waits, also at the start.
        sample_time: Time between two samples [s].
        real_time: Whether the loop waits only at the start.
        own: Recorded topics of the plant.
    """
    if not samples:
        return RecorderWindow(0)
    width = 0 if real_time else stamp_ns(samples, sample_time) - stamp_ns(0, sample_time)
    others = [name for name in sampled_topics() if name not in own]
    return RecorderWindow(width, own, others)


def read_recorder_progress(message: bytes) -> tuple[str, int]:
    """Decode a confirmation of the recorder: topic name, empty for all topics together, and stamp [ns]."""
    cursor = CdrCursor(message)
    cursor.skip(8, "stamp")
    return cursor.string("frame_id"), stamp_of(message)
