"""What becomes of a recorded message, free of ROS: repeats are left out, gaps are counted."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from flexros.logs.stamps import NANOSECONDS, START_NS, stamp_of

if TYPE_CHECKING:
    from collections.abc import Callable


FARTHEST = 10 * NANOSECONDS
"""A stamp that lies farther ahead than this is doubted [ns], chosen: any node may send on a topic."""


class MessageSink(Protocol):
    """Where messages go; `flexros.logs.writer.LogWriter` is one."""

    def write(self, topic_id: int, log_time_ns: int, publish_time_ns: int, payload: bytes) -> None:
        """Take one message."""


class ArrivalTime:
    """Log time of a run in real time: the simulated time of the first sample plus the wall clock since then.

    Args:
        clock: Gives the time of a monotonic clock [s].
    """

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._first: float | None = None

    def begin(self) -> None:
        """Note that a sample has come; the first one sets the origin."""
        if self._first is None:
            self._first = self._clock()

    def __call__(self) -> int:
        """Give the log time of a message that comes now [ns]."""
        return START_NS if self._first is None else START_NS + round((self._clock() - self._first) * NANOSECONDS)


class TopicRecording:
    """Messages of one topic that carries one message for each sampling instant.

    Args:
        sink: Where the messages go.
        topic_id: Number of the topic there.
        arrival: Gives the log time [ns]; the stamp if None.
        on_first: Called when the first message has been taken.

    Attributes:
        first: Stamp of the first message [ns], -1 before.
        last: Stamp of the newest message [ns], -1 before.
        count: Messages written.
        repeated: Messages whose stamp was there already, left out.
        doubted: Messages whose stamp lay before the start, or far ahead and alone there, left out.
    """

    def __init__(
        self,
        sink: MessageSink,
        topic_id: int,
        arrival: Callable[[], int] | None = None,
        on_first: Callable[[], object] = lambda: None,
    ) -> None:
        self.first = -1
        self.last = -1
        self.count = 0
        self.repeated = 0
        self.doubted = 0
        self._doubtful: tuple[int, bytes] | None = None
        self._write = sink.write
        self._topic_id = topic_id
        self._arrival = arrival
        self._on_first = on_first

    def take(self, message: bytes) -> None:
        """Write a message unless its stamp is not newer than the last one, before the start, or far ahead and alone.

        Args:
            message: Serialised message that begins with a std_msgs/Header.

        Raises:
            MessageError: The bytes hold no stamp.
        """
        stamp = stamp_of(message)
        if stamp < START_NS:  # no run begins before
            self.doubted += 1
        elif stamp <= self.last:
            self.repeated += 1
        elif stamp - self.last <= FARTHEST:
            self._keep(stamp, message)
        else:
            self._doubt(stamp, message)

    def _doubt(self, stamp: int, message: bytes) -> None:
        """Hold a message back that lies far ahead, until the next one shows that the loop goes on from there."""
        before, self._doubtful = self._doubtful, (stamp, message)
        self.doubted += 1
        if before is not None and 0 < stamp - before[0] <= FARTHEST:
            self.doubted -= 2
            self._doubtful = None
            self._keep(*before)
            self._keep(stamp, message)

    def _keep(self, stamp: int, message: bytes) -> None:
        self.last = stamp
        self.count += 1
        self._write(self._topic_id, stamp if self._arrival is None else self._arrival(), stamp, message)
        if self.first < 0:
            self.first = stamp
            self._on_first()

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
        arrival: Gives the log time [ns]; the stamp if None, or the present where the stamp is of another time.
        present: Gives the newest stamp of the loop [ns].
        read_stamp: Reads the stamp of a message [ns]; default: of one that begins with a std_msgs/Header.

    Attributes:
        count: Messages written.
    """

    def __init__(
        self,
        sink: MessageSink,
        topic_id: int,
        arrival: Callable[[], int] | None = None,
        present: Callable[[], int] = lambda: START_NS,
        read_stamp: Callable[[bytes], int] = stamp_of,
    ) -> None:
        self._present = present
        self._read_stamp = read_stamp
        self.count = 0
        self._sink = sink
        self._topic_id = topic_id
        self._arrival = arrival

    def take(self, message: bytes) -> None:
        """Write a message."""
        stamp = self._read_stamp(message)
        self.count += 1
        log_time = self._log_time(stamp) if self._arrival is None else self._arrival()
        self._sink.write(self._topic_id, log_time, max(stamp, 0), message)

    def _log_time(self, stamp: int) -> int:
        present = self._present()
        return stamp if stamp >= 0 and abs(stamp - present) <= FARTHEST else present
