"""A controller at the other end of a replay: what it still owes, and whether its commands are the recorded ones."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.errors import RunError
from flexros.logs.messages.joint_state import JointStateView
from flexros.logs.stamps import NANOSECONDS, stamp_of

if TYPE_CHECKING:
    from flexros.logs.replay.controller_feed import ControllerFeed

FIRST_REPEAT = 0.1
"""Time without a command after which the measurement is sent again [s] (wall clock), chosen."""


class ControllerAnswers:
    """Bookkeeping of measurements and commands; the clock is given, not fetched.

    Args:
        feed: The recorded reference and commands.
        timeout: Time without a command after which the controller counts as gone [s].

    Attributes:
        equal: Commands that equal the recorded ones in every bit.
        different: Commands that do not.
        unknown: Commands to stamps at which none was recorded.
        repeats: Measurements that were sent again.
    """

    def __init__(self, feed: ControllerFeed, timeout: float) -> None:
        self._feed = feed
        self._timeout = timeout
        self._view = JointStateView(feed.joint_names)
        self.equal = self.different = self.unknown = self.repeats = 0
        self._open = -1
        self._state = b""
        self._sent = self._since = 0.0
        self._n_chunks = 0

    @property
    def waits(self) -> bool:
        """Whether the newest measurement has no command yet."""
        return self._open >= 0

    def sent_chunk(self) -> None:
        """Note that the next chunk of the reference has gone out."""
        self._n_chunks += 1

    def sent_state(self, payload: bytes, now: float) -> None:
        """Note that a measurement has gone out, now [s]."""
        self._open, self._state = stamp_of(payload), payload
        self._sent = self._since = now

    def take(self, payload: bytes) -> bool:
        """Take a command; tells whether it is the one that was waited for.

        Raises:
            RunError: It is no command for these joints.
        """
        if stamp_of(payload) != self._open:
            return False
        sample = self._view.unpack(payload)
        recorded = self._feed.commands.get(sample.stamp_ns)
        if recorded is None:
            self.unknown += 1
        elif sample.effort == recorded:
            self.equal += 1
        else:
            self.different += 1
        self._open = -1
        return True

    def to_repeat(self, now: float) -> tuple[bytes, tuple[bytes, ...]]:
        """Give the measurement and the chunks that are to be sent again now [s]; empty where nothing is.

        Raises:
            RunError: The controller has been silent for too long.
        """
        if not self.waits or now - self._since < FIRST_REPEAT:
            return b"", ()
        if now - self._sent > self._timeout:
            raise RunError(
                f"no command to the measurement at stamp {self._open / NANOSECONDS:.4f} s came within "
                f"{self._timeout:g} s; start a controller with the scenario of the log and with observers:=0, or "
                "replay without feeding one"
            )
        self._since = now
        self.repeats += 1
        played = self._feed.chunks[: self._n_chunks]
        return self._state, tuple(chunk.payload for chunk in played if chunk.last_stamp >= self._open)
