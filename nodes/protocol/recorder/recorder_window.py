"""Flow control between plant and recorder."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

FIRST_SAMPLE_PATIENCE = 2.0
"""Wait for the first sample of a topic of a partner [s], chosen: a foreign controller may not publish all of them."""
PATIENCE_SHARE = 0.6
"""The same for a topic that has a publisher, as a part of the time-out of the recorder, chosen: connecting may take
seconds under load, and the loop begins before the recorder counts as gone."""


class RecorderWindow:
    """Limits how far the loop runs ahead of the confirmed recording.

    A queue with history keep-last overwrites unread messages when its reader falls behind, even with reliable
    transport. In lock-step the plant therefore waits until the recorder has confirmed. It also waits at the first
    sample, and repeats it, until the recorder has it on every topic: the number of subscriptions is not sufficient,
    because one may belong to a dead process while the live one is discovered later.

    Args:
        window_ns: Largest lead of the loop [ns]; 0 disables the flow control.
        own: Topics of the plant whose first sample must be recorded before the loop continues.
        others: Topics of its partners, awaited likewise, but for a limited time.

    Attributes:
        confirmed: Newest stamp up to which all topics are recorded [ns].
        by_topic: Newest stamp up to which each topic is recorded [ns].
        held: Whether a sample is held back.
        waits: Number of samples that were held back.
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
        """Process a confirmation.

        Args:
            topic: Topic that is recorded; empty for all topics together.
            stamp: Stamp up to which it is recorded [ns].
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
        """Restrict the window to these topics: the publisher of the others is gone."""
        self._followed = tuple(topics)
        self.confirm("", min(self.by_topic.get(each, 0) for each in self._followed))

    def admits(self, stamp: int) -> bool:
        """Return whether the sample with this stamp [ns] may be published now."""
        return stamp <= self._limit

    def hold(self) -> None:
        """Register that a sample is held back."""
        self.held = True
        self.waits += 1
        self._silence = 0.0

    def wait(self, time: float) -> float:
        """Add a wait for the recorder [s]; return the time without a confirmation [s]."""
        self._silence += time
        return self._silence

    def has_begun(self, published: Callable[[str], bool], timeout: float) -> bool:
        """Return whether the first sample is recorded, so that the loop may continue.

        Args:
            published: Returns whether a topic has a publisher, so that a longer wait is worthwhile.
            timeout: Time without a confirmation after which the recorder counts as gone [s].
        """
        if not self.holds(self._own, self._first):
            return False
        missing = [topic for topic in self._others if not self.holds((topic,), self._first)]
        if not missing or self._silence > PATIENCE_SHARE * timeout:
            return True
        return self._silence > FIRST_SAMPLE_PATIENCE and not any(published(topic) for topic in missing)

    def holds(self, topics: Iterable[str], stamp: int) -> bool:
        """Return whether all these topics are recorded up to a stamp [ns]."""
        return all(self.by_topic.get(topic, -1) >= stamp for topic in topics)
