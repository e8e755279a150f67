"""What becomes of a recorded message, free of ROS: repeats are left out, gaps are counted."""

from __future__ import annotations

from typing import Protocol

from flexros.logs.stamps import stamp_of


class MessageSink(Protocol):
    """Where messages go; `flexros.logs.writer.LogWriter` is one."""

    def write(self, topic_id: int, log_time_ns: int, publish_time_ns: int, payload: bytes) -> None:
        """Take one message."""


class TopicRecording:
    """Messages of one topic that carries one message for each sampling instant.

    Args:
        sink: Where the messages go.
        topic_id: Number of the topic there.

    Attributes:
        first: Stamp of the first message [ns], -1 before.
        last: Stamp of the newest message [ns], -1 before.
        count: Messages written.
        repeated: Messages whose stamp was there already, left out.
    """

    def __init__(self, sink: MessageSink, topic_id: int) -> None:
        self.first = -1
        self.last = -1
        self.count = 0
        self.repeated = 0
        self._write = sink.write
        self._topic_id = topic_id

    def take(self, message: bytes) -> None:
        """Write a message unless its stamp is not newer than the last one.

        Args:
            message: Serialised message that begins with a std_msgs/Header.
        """
        stamp = stamp_of(message)
        if stamp <= self.last:
            self.repeated += 1
            return
        if self.first < 0:
            self.first = stamp
        self.last = stamp
        self.count += 1
        self._write(self._topic_id, stamp, stamp, message)

    def missing(self, sample_time: float) -> int:
        """Count sampling instants between the first and the last message that have none.

        Args:
            sample_time: Time between two samples [s].
        """
        if self.count == 0:
            return 0
        return round((self.last - self.first) / (sample_time * 1e9)) + 1 - self.count


class EventRecording:
    """Messages of a topic that comes at any time, each of which counts.

    Args:
        sink: Where the messages go.
        topic_id: Number of the topic there.

    Attributes:
        count: Messages written.
    """

    def __init__(self, sink: MessageSink, topic_id: int) -> None:
        self.count = 0
        self._sink = sink
        self._topic_id = topic_id

    def take(self, message: bytes) -> None:
        """Write a message that begins with a std_msgs/Header."""
        stamp = stamp_of(message)
        self.count += 1
        self._sink.write(self._topic_id, stamp, stamp, message)
