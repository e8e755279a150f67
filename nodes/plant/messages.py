"""Messages of the plant: state, tool pose and clock of one sample."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosgraph_msgs.msg import Clock

from flexros.logs.messages.cdr_cursor import CdrCursor
from flexros.logs.messages.joint_state import JointStateTemplate
from flexros.logs.messages.pose_stamped import PoseStampedTemplate
from flexros.logs.stamps import NANOSECONDS, stamp_ns, stamp_of
from flexros.logs.time_series import BASE_FRAME
from flexros_nodes.protocol.recorder.recorder_window import RecorderWindow
from flexros_nodes.shell.topic_interface import period, sampled_topics, topic

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros_nodes.shell.node_base import FlexrosNode

OWN_TOPICS = ("joint_states", "tool_pose")
"""Recorded topics of the plant."""


class PlantMessages:
    """Fills the messages of one sample, and publishes them once or repeatedly.

    Args:
        node: The plant node.
        names: Joint names.
        sample_time: Time between two samples [s].
    """

    def __init__(self, node: FlexrosNode, names: Sequence[str], sample_time: float) -> None:
        self._node = node
        self._sample_time = sample_time
        self._states = node.announce("joint_states")
        self._poses = node.announce("tool_pose")
        self._clock = node.announce("clock")
        self._clock_every = max(round(period("clock") / sample_time), 1)
        self._state_template = JointStateTemplate(names, position=True)
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

    def fill(self, k: int, position: FloatArray, pose: FloatArray) -> int:
        """Fill the messages of a sample.

        Args:
            k: Sample.
            position: Measured motor positions [rad or m], shape (M,).
            pose: Tool pose x, y, z [m], quaternion x, y, z, w, shape (7,).

        Returns:
            The stamp [ns].
        """
        stamp = stamp_ns(k, self._sample_time)
        values = pose.tolist()
        self._state = self._state_template.fill(stamp, position=position)
        self._pose = self._pose_template.fill(stamp, values[:3], values[3:])
        self._clock_message = None
        if k % self._clock_every == 0:
            self._clock_message = Clock()
            self._clock_message.clock.sec, self._clock_message.clock.nanosec = divmod(stamp, NANOSECONDS)
        return stamp

    def publish(self) -> None:
        """Publish the messages of the sample, also repeatedly."""
        self._states.publish(self._state)
        self._poses.publish(self._pose)
        if self._clock_message is not None:
            self._clock.publish(self._clock_message)


def recorder_window(samples: int, sample_time: float, real_time: bool) -> RecorderWindow:
    """Create the flow control between plant and recorder.

    Args:
        samples: Samples that the loop may run ahead of the recorder; 0 disables all waits, also at the start.
        sample_time: Time between two samples [s].
        real_time: Whether the loop waits only at the start.
    """
    if not samples:
        return RecorderWindow(0)
    width = 0 if real_time else stamp_ns(samples, sample_time) - stamp_ns(0, sample_time)
    others = [name for name in sampled_topics() if name not in OWN_TOPICS]
    return RecorderWindow(width, OWN_TOPICS, others)


def read_recorder_progress(message: bytes) -> tuple[str, int]:
    """Decode a confirmation of the recorder: topic name, empty for all topics together, and stamp [ns]."""
    cursor = CdrCursor(message)
    cursor.skip(8, "stamp")
    return cursor.string("frame_id"), stamp_of(message)
