"""Flow control between plant and recorder, free of ROS: when the loop may begin, and how far it may run ahead."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

FIRST_SAMPLE_PATIENCE = 2.0
"""Time that the first sample of a topic not from the plant may be late [s], chosen: another controller may lack one."""
LONGEST_PATIENCE = 6.0
"""The same of a topic that somebody publishes [s], chosen: a machine under load may take seconds to connect it, and the
time-out of the recorder is longer."""


class RecorderWindow:
    """How far the loop may run ahead of what is known to be recorded.

    A queue that keeps the last messages overwrites unread ones when its reader falls behind, even with reliable
    transport. The plant therefore waits in lock-step until the recorder has confirmed. It also waits at the first
    sample, and repeats it, until the recorder has it on every topic: that there are readers says nothing, one of them
    may belong to a process that is dead, and the one that counts be known to others only later.

    Args:
        window_ns: How far the loop may run ahead [ns]; 0 switches the flow control off.
        own: Topics of the plant whose first sample must be recorded before the loop goes on.
        others: Topics of its partners for which this is awaited too, but not for ever.

    Attributes:
        confirmed: Newest stamp up to which everything is recorded [ns].
        by_topic: Newest stamp up to which a topic is recorded, by topic [ns].
        held: Whether the plant holds a sample back.
        waits: Times that it had to.
    """

    def __init__(self, window_ns: int, own: Iterable[str] = (), others: Iterable[str] = ()) -> None:
        self.confirmed = 0
        self.by_topic: dict[str, int] = {}
        self.held = False
        self.waits = 0
        self._window_ns = window_ns
        self._own = tuple(own)
        self._others = tuple(others)
        self._first = 0
        self._silence = 0.0
        self._limit: float = float("inf")
        self._followed: tuple[str, ...] = ()

    def start(self, stamp: int) -> None:
        """Begin at the stamp of the first sample [ns]."""
        self._first = stamp
        self._silence = 0.0
        self.confirm("", stamp)

    def confirm(self, topic: str, stamp: int) -> None:
        """Note a confirmation.

        Args:
            topic: What is recorded; empty for all topics together.
            stamp: Up to where [ns].
        """
        if topic:
            self.by_topic[topic] = max(stamp, self.by_topic.get(topic, 0))
            stamp = min((self.by_topic.get(each, 0) for each in self._followed), default=0)
        if stamp > self.confirmed:
            self.confirmed = stamp
            self._silence = 0.0
            if self._window_ns:
                self._limit = stamp + self._window_ns

    def follow(self, topics: Iterable[str]) -> None:
        """Let these topics alone move the window from now on: the partner that sends the others is gone.

        Args:
            topics: Their names.
        """
        self._followed = tuple(topics)
        self.confirm("", min(self.by_topic.get(each, 0) for each in self._followed))

    def admits(self, stamp: int) -> bool:
        """Tell whether the sample with this stamp [ns] may be published now."""
        return stamp <= self._limit

    def hold(self) -> None:
        """Note that a sample is held back."""
        self.held = True
        self.waits += 1
        self._silence = 0.0

    def wait(self, time: float) -> float:
        """Note that the plant has waited for the recorder [s]; gives for how long nothing was confirmed [s]."""
        self._silence += time
        return self._silence

    def has_begun(self, published: Callable[[str], bool]) -> bool:
        """Tell whether the first sample is recorded, so that the loop may go on.

        Args:
            published: Tells whether somebody publishes a topic, so that it is worth a longer wait.
        """
        if not self.holds(self._own, self._first):
            return False
        missing = [topic for topic in self._others if not self.holds((topic,), self._first)]
        if not missing or self._silence > LONGEST_PATIENCE:
            return True
        return self._silence > FIRST_SAMPLE_PATIENCE and not any(published(topic) for topic in missing)

    def holds(self, topics: Iterable[str], stamp: int) -> bool:
        """Tell whether all these topics are recorded up to a stamp [ns]."""
        return all(self.by_topic.get(topic, -1) >= stamp for topic in topics)
