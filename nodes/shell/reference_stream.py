"""Streaming a reference ahead of the loop, shared by the nodes that lead a run."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.logs.messages.joint_trajectory import JointTrajectoryChunk, serialise_joint_trajectory
from flexros.logs.messages.pose_stamped import PoseStampedTemplate
from flexros.logs.stamps import START_NS, sample_number, stamp_of, stamps_ns
from flexros.logs.time_series import BASE_FRAME
from flexros_nodes.protocol.loop.lockstep import RestartDetector
from flexros_nodes.protocol.reference.chunk_stream import ChunkStream
from flexros_nodes.protocol.reference.reference_rows import PlannedRows
from flexros_nodes.shell.topic_interface import period

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.scenario.experiment import Experiment
    from flexros_nodes.protocol.reference.reference_rows import ReferenceRows
    from flexros_nodes.shell.node_base import FlexrosNode

FIND_PERIOD = 0.01
"""Period at which the node looks whether its readers are there [s], chosen."""

CLOCK_PERIODS_AHEAD = 2
"""Periods of the clock by which tool references are sent ahead: one may be lost without a gap, chosen."""

STALL_PERIODS = 16
"""A loop that stands still gets its chunks again after 1, 2, 4, 8 and then every 16 time-outs, chosen."""


class ReferenceStream:
    """The reference of a run in chunks that append to each other, and the tool reference beside it.

    /clock tells how far the loop is. When it stands still, what its readers may lack is sent again; so is a chunk
    that is not confirmed by a controller which has confirmed others. That does no harm: a message says the same
    however often it comes. When the loop begins anew, so does the stream.

    Args:
        node: Node that owns the topics; configured anew, it makes a new stream.
        run: What runs; its reference is computed here.

    Attributes:
        progress: Newest sample of the loop that is known.
        clock_samples: Samples between two messages of the clock.
        closed: Whether nothing is sent yet; set it before `start`, and call `open` when the time has come.
        on_progress: Called with the progress when it has grown, before anything is sent.
        on_restart: Called when the loop has begun anew, before anything is sent.
    """

    def __init__(self, node: FlexrosNode, run: Experiment) -> None:
        self._node = node
        self._names = run.nominal.joint_names
        self._sample_time = run.sample_time
        self._n_samples = run.n_samples
        self._planned = PlannedRows(run.reference)
        self._stamps = stamps_ns(self._n_samples, self._sample_time)
        self.clock_samples = max(round(period("clock") / self._sample_time), 1)
        self._pose_message = PoseStampedTemplate(BASE_FRAME)
        self.on_progress: Callable[[int], None] = lambda _: None
        self.on_restart: Callable[[], None] = lambda: None
        self.closed = False
        self._begin()
        self._chunks = node.announce("joint_reference_ahead")
        self._poses = node.announce("tool_reference")
        node.listen("clock", self._on_clock)
        node.listen("reference_received", self._on_received)

    def _begin(self) -> None:
        """Stand before the first chunk."""
        value, sample_time = self._node.value, self._sample_time
        chunk = max(round(value("chunk_duration") / sample_time), 1)
        self._stream = ChunkStream(self._n_samples, chunk, round(value("lead") / sample_time))
        self._rows: ReferenceRows = self._planned
        self.progress = self._seen = self._poses_sent = 0
        self._stalls = 0
        self._restart = RestartDetector()
        self._found = self._running = False

    @property
    def sent(self) -> int:
        """Samples that have been sent, from 0: these cannot be changed any more."""
        return self._stream.sent

    def start(self) -> None:
        """Stand before the first chunk and look for the readers; it goes out when they are there."""
        self._begin()
        self._node.every(FIND_PERIOD, self._find_readers)
        self._node.every(self._node.value("resend_timeout"), self._watch)

    def open(self) -> None:
        """Begin to send."""
        self.closed = False
        if self._found:
            self._send_due()

    def replace(self, rows: ReferenceRows) -> None:
        """Send these rows from now on; they have to agree with what has been sent already."""
        self._rows = rows

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
        observers = self._node.value("observers")
        self._found = self._chunks.get_subscription_count() > 0 and self._poses.get_subscription_count() >= observers
        if self._found and not self.closed:
            self._send_due()

    def _on_clock(self, message: bytes) -> None:
        # rosgraph_msgs/Clock is a time alone, which lies where other messages have header.stamp
        self._node.stamp = stamp = stamp_of(message)
        if stamp == START_NS and self.progress and self._restart.restarted(self.progress):
            self._begin()
            self.on_restart()
        self._running = True
        progress = max(self.progress, sample_number(stamp, self._sample_time))
        if progress > self.progress:
            self.progress = progress
            self.on_progress(progress)
        if self._found and not self.closed:
            self._send_due()

    def _on_received(self, message: bytes) -> None:
        for samples in self._stream.confirm(sample_number(stamp_of(message), self._sample_time)):
            self._send(samples)

    def _send_due(self) -> None:
        for samples in self._stream.due(self.progress):
            self._send(samples)
        # at the first sample the loop waits until every reader is known: what is sent again then must be one message
        stop = min(self.progress + CLOCK_PERIODS_AHEAD * self.clock_samples, self._n_samples) if self.progress else 1
        self._send_poses(range(self._poses_sent, stop))
        self._poses_sent = max(self._poses_sent, stop)

    def _send_poses(self, samples: range) -> None:
        if not samples:
            return
        poses = self._rows.rows(samples).tool_pose.tolist()
        for k, pose in zip(samples, poses, strict=True):
            self._poses.publish(self._pose_message.fill(int(self._stamps[k]), pose[:3], pose[3:]))

    def _send(self, samples: range) -> None:
        reference = self._rows.rows(samples)
        stamps = self._stamps[samples.start : samples.stop]
        chunk = JointTrajectoryChunk(
            int(stamps[0]),
            self._names,
            stamps - stamps[0],
            positions=reference.motor_position,
            velocities=reference.motor_velocity,
            effort=reference.torque,
        )
        self._chunks.publish(serialise_joint_trajectory(chunk))

    def _watch(self) -> None:
        """Send again what has not arrived, and what a loop that stands still may lack."""
        stands_still = self._running and self.progress == self._seen and self.progress < self._n_samples - 1
        self._seen = self.progress
        self._stalls = self._stalls + 1 if stands_still else 0
        if stands_still and (self._stalls & (self._stalls - 1) == 0 or self._stalls % STALL_PERIODS == 0):
            lacking = self._stream.since(self.progress)
            self._send_poses(range(self.progress, self._poses_sent))
        else:
            lacking = self._stream.overdue(self.progress)
        for samples in lacking:
            self._send(samples)
