"""Feedforward node: streams the motor reference ahead of the loop, and the tool reference beside it."""

from __future__ import annotations

from flexros.logs.joint_trajectory_message import JointTrajectoryChunk, serialise_joint_trajectory
from flexros.logs.pose_stamped_message import PoseStampedTemplate
from flexros.logs.stamps import sample_number, stamp_of, stamps_ns
from flexros.logs.time_series import BASE_FRAME
from flexros_nodes.chunk_stream import ChunkStream
from flexros_nodes.executable import run_node
from flexros_nodes.node_base import FlexrosNode
from flexros_nodes.prepared_run import prepared_run
from flexros_nodes.topic_interface import topic

FIND_PERIOD = 0.01
"""Period at which the node looks whether its readers are there [s], chosen."""

CLOCK_PERIODS_AHEAD = 2
"""Periods of the clock by which tool references are sent ahead: one may be lost without a gap, chosen."""


STALL_PERIODS = 16
"""A loop that stands still gets its chunks again after 1, 2, 4, 8 and then every 16 time-outs, chosen."""


class FeedforwardNode(FlexrosNode):
    """The reference of a scenario, in chunks that append to each other.

    /clock tells how far the loop is. When it stands still the chunks that the controller may lack are sent again, which
    does no harm: a chunk says the same however often it comes.
    """

    node_name = "feedforward"

    def configure(self) -> None:
        """Compute the reference; make publishers and the subscription to the clock."""
        run = prepared_run(self.value("scenario"))
        self._names = run.nominal.joint_names
        self._sample_time = run.sample_time
        self._n_samples = run.n_samples
        self._reference = run.reference
        self._stamps = stamps_ns(self._n_samples, self._sample_time)
        clock_period = 1.0 / (topic("clock").rate or 1.0)
        self._poses_ahead = max(round(CLOCK_PERIODS_AHEAD * clock_period / self._sample_time), 1)
        self._pose_message = PoseStampedTemplate(BASE_FRAME)
        self._begin()
        self._chunks = self.announce("joint_reference_ahead")
        self._poses = self.announce("tool_reference")
        self.listen("clock", self._on_clock)

    def _begin(self) -> None:
        """Stand before the first chunk."""
        chunk = max(round(self.value("chunk_duration") / self._sample_time), 1)
        self._stream = ChunkStream(self._n_samples, chunk, round(self.value("lead") / self._sample_time))
        self._progress = self._seen = self._poses_sent = 0
        self._stalls = 0
        self._found = self._running = False

    def start(self) -> None:
        """Look for the readers; the first chunks go out when they are there."""
        self._begin()
        self.every(FIND_PERIOD, self._find_readers)
        self.every(self.value("resend_timeout"), self._watch)

    def figures(self) -> dict[str, float]:
        """Give what was sent and sent again."""
        return {
            "samples_sent": self._stream.sent,
            "chunks_resent": self._stream.resends,
            "tool_references_sent": self._poses_sent,
        }

    def _find_readers(self) -> None:
        if self._found:
            return
        self._found = self._chunks.get_subscription_count() > 0 and self._poses.get_subscription_count() >= self.value(
            "observers"
        )
        if self._found:
            self._send_due()

    def _on_clock(self, message: bytes) -> None:
        # rosgraph_msgs/Clock is a time alone, which lies where other messages have header.stamp
        self.stamp = stamp_of(message)
        self._running = True
        self._progress = max(self._progress, sample_number(self.stamp, self._sample_time))
        if self._found:
            self._send_due()

    def _send_due(self) -> None:
        for samples in self._stream.due(self._progress):
            self._send(samples)
        stop = min(self._progress + self._poses_ahead, self._n_samples)
        reference, message = self._reference.tool_pose, self._pose_message
        for k in range(self._poses_sent, stop):
            pose = reference[k].tolist()
            self._poses.publish(message.fill(int(self._stamps[k]), pose[:3], pose[3:]))
        self._poses_sent = max(self._poses_sent, stop)

    def _send(self, samples: range) -> None:
        rows = slice(samples.start, samples.stop)
        stamps = self._stamps[rows]
        chunk = JointTrajectoryChunk(
            int(stamps[0]),
            self._names,
            stamps - stamps[0],
            positions=self._reference.motor_position[rows],
            velocities=self._reference.motor_velocity[rows],
            effort=self._reference.torque[rows],
        )
        self._chunks.publish(serialise_joint_trajectory(chunk))

    def _watch(self) -> None:
        """Send again what a loop that stands still may lack."""
        stands_still = self._running and self._progress == self._seen and self._progress < self._n_samples - 1
        self._seen = self._progress
        self._stalls = self._stalls + 1 if stands_still else 0
        if stands_still and (self._stalls & (self._stalls - 1) == 0 or self._stalls % STALL_PERIODS == 0):
            for samples in self._stream.again(self._progress):
                self._send(samples)


def main() -> int:
    """Run the node as an executable."""
    return run_node(FeedforwardNode)


if __name__ == "__main__":
    raise SystemExit(main())
