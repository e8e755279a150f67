"""Recording of messages: log time, repeats, implausible stamps and missing samples."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from flexros.logs.stamps import NANOSECONDS, START_NS, stamp_of

if TYPE_CHECKING:
    from collections.abc import Callable


LARGEST_STEP = 10 * NANOSECONDS
"""Largest plausible step between two stamps [ns], chosen: any node may publish on a topic."""


class MessageSink(Protocol):
    """Destination of messages; `flexros.logs.writer.LogWriter` is one."""

    def write(self, topic_id: int, log_time_ns: int, publish_time_ns: int, payload: bytes) -> None:
        """Write one message."""


class ArrivalTime:
    """Log time of a real-time run: simulated time of the first sample plus wall-clock time since then.

    Args:
        clock: Returns the time of a monotonic clock [s].
    """

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._first: float | None = None

    def begin(self) -> None:
        """Register a sample; the first one sets the origin."""
        if self._first is None:
            self._first = self._clock()

    def __call__(self) -> int:
        """Return the log time of a message that arrives now [ns]."""
        return START_NS if self._first is None else START_NS + round((self._clock() - self._first) * NANOSECONDS)


class TopicRecording:
    """Records a topic that carries one message per sampling instant, or every so many of them.

    Args:
        sink: Destination of the messages.
        topic_id: Number of the topic in the sink.
        arrival: Returns the log time [ns]; the stamp is used if None.
        on_first: Called after the first message is written.
        gap: Time after a message within which none is due [ns]: 0 for one message per sampling instant.

    Attributes:
        first: Stamp of the first message [ns], -1 before.
        last: Stamp of the newest message [ns], -1 before.
        count: Messages written.
        repeated: Dropped messages with a stamp that is already recorded.
        doubted: Dropped messages with an implausible stamp: before the start, or isolated far ahead.
    """

    def __init__(
        self,
        sink: MessageSink,
        topic_id: int,
        arrival: Callable[[], int] | None = None,
        on_first: Callable[[], object] = lambda: None,
        gap: int = 0,
    ) -> None:
        self.first = -1
        self.last = -1
        self._gap = gap
        self.count = 0
        self.repeated = 0
        self.doubted = 0
        self._doubtful: tuple[int, bytes] | None = None
        self._write = sink.write
        self._topic_id = topic_id
        self._arrival = arrival
        self._on_first = on_first

    def take(self, message: bytes) -> None:
        """Write a message unless its stamp is not newer than the last one, or implausible.

        Args:
            message: Serialised message that begins with a std_msgs/Header.

        Raises:
            MessageError: The bytes hold no stamp.
        """
        stamp = stamp_of(message)
        if stamp < START_NS:  # no run starts earlier
            self.doubted += 1
        elif stamp <= self.last:
            self.repeated += 1
        elif stamp - self.last <= LARGEST_STEP:
            self._keep(stamp, message)
        else:
            self._doubt(stamp, message)

    def _doubt(self, stamp: int, message: bytes) -> None:
        """Hold back a message far ahead until the next one confirms that the loop continues from there."""
        previous, self._doubtful = self._doubtful, (stamp, message)
        self.doubted += 1
        if previous is not None and 0 < stamp - previous[0] <= LARGEST_STEP:
            self.doubted -= 2
            self._doubtful = None
            self._keep(*previous)
            self._keep(stamp, message)

    def _keep(self, stamp: int, message: bytes) -> None:
        self.last = stamp
        self.count += 1
        self._write(self._topic_id, stamp if self._arrival is None else self._arrival(), stamp, message)
        if self.first < 0:
            self.first = stamp
            self._on_first()

    @property
    def until(self) -> int:
        """Stamp up to which no message is missing at the end [ns], -1 before the first."""
        return self.last + self._gap if self.count else -1

    def missing(self, sample_time: float) -> int:
        """Count the instants between the first and the last message at which one was due and is missing.

        Args:
            sample_time: Time between two samples [s].
        """
        if self.count == 0:
            return 0
        return round((self.last - self.first) / (sample_time * 1e9 + self._gap)) + 1 - self.count


class EventRecording:
    """Records a topic that publishes at any time; every message is kept.

    Args:
        sink: Destination of the messages.
        topic_id: Number of the topic in the sink.
        arrival: Returns the log time [ns]; if None, the stamp is used, or the present stamp where it is implausible.
        present: Returns the newest stamp of the loop [ns].
        read_stamp: Reads the stamp of a message [ns]; default: message that begins with a std_msgs/Header.

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
        return stamp if stamp >= 0 and abs(stamp - present) <= LARGEST_STEP else present
