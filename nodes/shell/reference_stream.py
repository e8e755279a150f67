"""Stream of the reference ahead of the loop, shared by feedforward and identification."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.logs.messages.joint_trajectory import JointTrajectoryChunk, serialise_joint_trajectory
from flexros.logs.messages.pose_stamped import PoseStampedTemplate
from flexros.logs.stamps import START_NS, sample_number, stamp_of, stamps_ns
from flexros.logs.time_series import BASE_FRAME
from flexros_nodes.protocol.loop.lockstep import RestartDetector
from flexros_nodes.protocol.reference.chunk_stream import ChunkStream
from flexros_nodes.protocol.reference.link_columns import names_with_links, with_links
from flexros_nodes.protocol.reference.reference_rows import PlannedRows
from flexros_nodes.shell.topic_interface import period

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.scenario.experiment import Experiment
    from flexros_nodes.protocol.reference.reference_rows import ReferenceRows
    from flexros_nodes.shell.node_base import FlexrosNode

FIND_PERIOD = 0.01
"""Period of the search for partners [s], chosen."""

CLOCK_PERIODS_AHEAD = 2
"""Lead of the tool references in clock periods, chosen: one clock message may be lost without a gap."""

PATIENCE = 5.0
"""Time of a search after which the log states what is missing [s], chosen."""

STALL_PERIODS = 16
"""Chunks are repeated to a stalled loop after 1, 2, 4, 8 and then every 16 time-outs, chosen."""


class ReferenceStream:
    """Streams the reference of a run in consecutive chunks, and the tool reference.

    The stream follows the loop by /clock, so it begins once a clock is connected too: a loop in real time that began
    before would use up the first chunks and end. When the loop stalls, everything it may lack is sent again; so is a
    chunk that remains unconfirmed by a controller that has confirmed others. Repeats are harmless, since messages are
    idempotent. When the loop restarts, so does the stream.

    Args:
        node: Node that owns the topics; it creates a new stream in each configuration.
        run: The run; its reference is computed here.

    Attributes:
        progress: Newest known sample of the loop.
        clock_samples: Samples between two messages of the clock.
        closed: Whether sending is suspended; set it before `start`, and call `open` to begin.
        on_progress: Called with the progress when it has increased, before anything is sent.
        on_restart: Called when the loop has restarted, before anything is sent.
    """

    def __init__(self, node: FlexrosNode, run: Experiment) -> None:
        node.claim("joint_reference_ahead")
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
        self._clock = node.listen("clock", self._on_clock)
        node.listen("reference_received", self._on_received)

    def _begin(self) -> None:
        """Return to the state before the first chunk."""
        value, sample_time = self._node.value, self._sample_time
        chunk = max(round(value("chunk_duration") / sample_time), 1)
        self._stream = ChunkStream(self._n_samples, chunk, round(value("lead") / sample_time))
        self._rows: ReferenceRows = self._planned
        self.progress = self._seen = self._poses_sent = 0
        self._stalls = 0
        self._restart = RestartDetector()
        self._partners_found = self._running = False
        self._searches = 0

    @property
    def sent(self) -> int:
        """Number of samples already sent, which can no longer be changed."""
        return self._stream.sent

    def start(self) -> None:
        """Search for the partners; the first chunk is sent once they are connected."""
        self._begin()
        self._node.every(FIND_PERIOD, self._find_partners)
        self._node.every(self._node.value("resend_timeout"), self._watch)

    def open(self) -> None:
        """Start sending."""
        self.closed = False
        if self._partners_found:
            self._send_due()

    def replace(self, rows: ReferenceRows) -> None:
        """Send these rows from now on; they must agree with the samples already sent."""
        self._rows = rows

    def figures(self) -> dict[str, float]:
        """Return counts of sent and repeated messages."""
        return {
            "samples_sent": self._stream.sent,
            "chunks_resent": self._stream.resends,
            "tool_references_sent": self._poses_sent,
        }

    def _find_partners(self) -> None:
        if self._partners_found:
            return
        missing = self._missing()
        self._partners_found = not missing
        self._searches += 1
        if self._searches == round(PATIENCE / FIND_PERIOD):
            self._node.get_logger().info(f"the reference waits for {' and '.join(missing)}")
        if self._partners_found and not self.closed:
            self._send_due()

    def _missing(self) -> list[str]:
        observers = self._node.value("observers")
        connected = {
            "a controller that listens to joint_reference_ahead": self._chunks.get_subscription_count() > 0,
            f"{observers} recorders of tool_reference": self._poses.get_subscription_count() >= observers,
            "a plant that publishes /clock": self._clock.get_publisher_count() > 0,
        }
        return [partner for partner, found in connected.items() if not found]

    def _on_clock(self, message: bytes) -> None:
        # rosgraph_msgs/Clock is only a time, at the position of header.stamp in other messages
        self._node.stamp = stamp = stamp_of(message)
        if stamp == START_NS and self.progress and self._restart.restarted(self.progress):
            self._begin()
            self.on_restart()
        self._running = True
        progress = max(self.progress, sample_number(stamp, self._sample_time))
        if progress > self.progress:
            self.progress = progress
            self.on_progress(progress)
        if self._partners_found and not self.closed:
            self._send_due()

    def _on_received(self, message: bytes) -> None:
        for samples in self._stream.confirm(sample_number(stamp_of(message), self._sample_time)):
            self._send(samples)

    def _send_due(self) -> None:
        for samples in self._stream.due(self.progress):
            self._send(samples)
        # the loop waits at the first sample until all subscribers are connected: repeats must be that one message
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
        position, velocity, effort = reference.motor_position, reference.motor_velocity, reference.torque
        names = self._names
        if (links := reference.link_motion).size:
            names = names_with_links(names)
            position, velocity = with_links(position, links, 0), with_links(velocity, links, 1)
            effort = np.pad(effort, ((0, 0), (0, len(names) - len(self._names))))
        chunk = JointTrajectoryChunk(
            int(stamps[0]), names, stamps - stamps[0], positions=position, velocities=velocity, effort=effort
        )
        self._chunks.publish(serialise_joint_trajectory(chunk))

    def _watch(self) -> None:
        """Repeat unconfirmed chunks, and everything that a stalled loop may lack."""
        stalled = self._running and self.progress == self._seen and self.progress < self._n_samples - 1
        self._seen = self.progress
        self._stalls = self._stalls + 1 if stalled else 0
        if stalled and (self._stalls & (self._stalls - 1) == 0 or self._stalls % STALL_PERIODS == 0):
            missing = self._stream.since(self.progress)
            self._send_poses(range(self.progress, self._poses_sent))
        else:
            missing = self._stream.overdue(self.progress)
        for samples in missing:
            self._send(samples)
