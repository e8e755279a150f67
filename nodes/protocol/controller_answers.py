"""Commands of a controller that is fed by a replay, compared with the recorded ones."""

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
    """Tracks open measurements and compares commands; times are arguments.

    Args:
        feed: Recorded reference and commands.
        timeout: Time without a command after which the controller counts as gone [s].

    Attributes:
        equal: Commands that are bit-equal to the recorded ones.
        different: Commands that are not.
        unknown: Commands for stamps without a recorded command.
        repeats: Repeated measurements.
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
        self._sensors: list[tuple[int, int, bytes]] = []

    @property
    def waits(self) -> bool:
        """Whether the newest measurement has no command yet."""
        return self._open >= 0

    def sent_chunk(self) -> None:
        """Register that the next chunk of the reference was sent."""
        self._n_chunks += 1

    def sent_sensor(self, topic: int, payload: bytes) -> None:
        """Register that a message of a further sensor was sent on a topic, by its index."""
        self._sensors.append((stamp_of(payload), topic, payload))

    @property
    def sensors_to_repeat(self) -> tuple[tuple[int, bytes], ...]:
        """Topics and messages of further sensors since the newest answered measurement, to be repeated with a state."""
        return tuple((topic, payload) for _, topic, payload in self._sensors)

    def sent_state(self, payload: bytes, now: float) -> None:
        """Register that a measurement was sent, now [s]."""
        self._open, self._state = stamp_of(payload), payload
        self._sent = self._since = now

    def add_command(self, payload: bytes) -> bool:
        """Process a command; return whether it answers the open measurement.

        Raises:
            RunError: The command is not for these joints.
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
        self._sensors = [sent for sent in self._sensors if sent[0] > self._open]
        self._open = -1
        return True

    def to_repeat(self, now: float) -> tuple[bytes, tuple[bytes, ...]]:
        """Return the measurement and the chunks to repeat now [s]; empty where nothing is due.

        Raises:
            RunError: The controller has not answered within the time-out.
        """
        if not self.waits or now - self._since < FIRST_REPEAT:
            return b"", ()
        if now - self._sent > self._timeout:
            raise RunError(
                f"no command for the measurement at stamp {self._open / NANOSECONDS:.4f} s arrived within "
                f"{self._timeout:g} s; start a controller with the scenario of the log and with observers:=0, or "
                "replay without feeding one"
            )
        self._since = now
        self.repeats += 1
        played = self._feed.chunks[: self._n_chunks]
        return self._state, tuple(chunk.payload for chunk in played if chunk.last_stamp >= self._open)
