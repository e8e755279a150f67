"""Lock-step protocol: state of the plant and of the controller.

The plant publishes the measurement with stamp k T and advances only on the command with the same stamp. The controller
answers each stamp once, repeats its last reply for a repeated stamp and drops older ones. The sequence depends on the
data alone and not on timing, so a run is the same with every executor, process layout and speed.
"""

from __future__ import annotations

from enum import Enum, auto

from flexros.logs.stamps import START_NS

HANDSHAKE_PERIOD = 0.1
"""Period of repeats of state 0 during discovery [s], chosen."""

FASTEST_RESEND = 0.002
"""Shortest resend time-out [s], chosen: ten times a round trip."""

ROUND_TRIPS = 5.0
"""Resend time-out in round trips, chosen."""

FORGETTING = 0.98
"""Decay of the largest round trip per tick, chosen: it halves within 34 ticks."""


FIRST_SAMPLE_AGAIN = 3
"""Repeats of the first sample after which the loop counts as restarted, chosen: a single one may be a late repeat."""


class Tick(Enum):
    """Action of the plant when its watch timer fires."""

    WAIT = auto()
    RESEND = auto()
    GIVE_UP = auto()


class Arrival(Enum):
    """Classification of a stamp that the controller receives."""

    NEW = auto()
    REPEATED = auto()
    OLD = auto()
    RESTARTED = auto()


class RestartDetector:
    """Distinguishes a restarted loop from a late repeat of its first sample.

    A plant repeats its first sample until it is answered. It has restarted when the first stamp arrives several times
    and nothing newer arrives in between.
    """

    def __init__(self) -> None:
        self._count = 0
        self._newest = -1

    def restarted(self, newest: int) -> bool:
        """Count a repeat of the first stamp; return whether the loop has restarted.

        Args:
            newest: Newest known stamp or sample.
        """
        self._count = self._count + 1 if newest == self._newest else 1
        self._newest = newest
        return self._count >= FIRST_SAMPLE_AGAIN


class PlantLockStep:
    """Plant side: one state in flight, repeated after a time-out, abandoned after a longer one.

    The watch timer calls `tick` at a fixed period. A state counts as unanswered when it has been in flight for at least
    one whole period, so that the hot path never reads a clock. The resend time-out adapts to the round trips observed
    by the ticks and doubles with every repeat.

    Args:
        tick_period: Period of the watch timer [s].
        resend_timeout: Longest time after which a state is sent again [s].
        partner_timeout: Time without an answer after which the partner counts as gone [s].
        start_timeout: The same for the first state, while other nodes start up [s].

    Attributes:
        awaited: Stamp of the state in flight [ns], -1 before the first.
        resends: Repeated states after the first reply.
        handshakes: Repeats of the first state.
        stale: Commands for a stamp other than the one in flight: repeats, or too late in real time.
    """

    def __init__(self, tick_period: float, resend_timeout: float, partner_timeout: float, start_timeout: float) -> None:
        self.awaited = -1
        self.resends = 0
        self.handshakes = 0
        self.stale = 0
        self._tick_period = tick_period
        self._resend_timeout = resend_timeout
        self._partner_timeout = partner_timeout
        self._start_timeout = start_timeout
        self._round_trip = resend_timeout / ROUND_TRIPS
        self._started = False
        self._seen = -1
        self._n_sent = 0
        self._repeats = 0
        self._uncertain = 0.0
        self._silence = 0.0
        self._since_sent = 0.0

    @property
    def silence(self) -> float:
        """Time since the watch timer first saw the state in flight [s]."""
        return self._silence

    def sent(self, stamp: int) -> None:
        """Register that the state with this stamp [ns] is in flight."""
        self._started = self._started or self.awaited >= 0
        self.awaited = stamp
        self._n_sent += 1

    def answers(self, stamp: int) -> bool:
        """Return whether a command's stamp [ns] answers the state in flight; count it as stale if not."""
        if stamp == self.awaited:
            return True
        self.stale += 1
        # a second answer: the state was not lost, only its round trip was longer
        slow = self._silence + self._tick_period if self._repeats else self._uncertain
        self._round_trip = max(self._round_trip, slow)
        self._uncertain = 0.0
        return False

    def hold(self) -> None:
        """Reset the silence: the plant itself keeps the loop waiting."""
        self._seen = -1
        self._n_sent = 0  # a wait of the plant is no round trip

    def tick(self) -> Tick:
        """Return the action for this period of the watch timer."""
        if self._seen != self.awaited:
            self._learn()
            self._seen = self.awaited
            self._n_sent = self._repeats = 0
            self._silence = self._since_sent = 0.0
            return Tick.WAIT
        self._silence += self._tick_period
        self._since_sent += self._tick_period
        if self._silence >= (self._partner_timeout if self._started else self._start_timeout):
            return Tick.GIVE_UP
        if self._since_sent < self._timeout() * (1.0 - 1e-9):
            return Tick.WAIT
        self._since_sent = 0.0
        self._repeats += 1
        if self._started:
            self.resends += 1
        else:
            self.handshakes += 1
        return Tick.RESEND

    def _timeout(self) -> float:
        """Return the time after which the state in flight is sent again [s]."""
        if not self._started:
            return HANDSHAKE_PERIOD
        longer = max(ROUND_TRIPS * self._round_trip, FASTEST_RESEND) * 2.0 ** min(self._repeats, 20)
        return min(longer, self._resend_timeout)

    def _learn(self) -> None:
        """Update the round trip with the mean since the previous tick; a repeated state gives none yet."""
        time = self._silence + self._tick_period
        if self._repeats:
            self._uncertain = time
        elif self._n_sent and self._started:
            self._round_trip = max(time / self._n_sent, FORGETTING * self._round_trip)


class ControllerLockStep:
    """Controller side: classification of arriving stamps.

    Args:
        sample_time: Time between two samples [s].

    Attributes:
        last: Newest stamp [ns], -1 before the first.
        repeated: Repeated states.
        old: Dropped states, older than the newest.
        missed: Samples skipped between two new states; zero in lock-step.
    """

    def __init__(self, sample_time: float) -> None:
        self.last = -1
        self.repeated = 0
        self.old = 0
        self.missed = 0
        self._sample_ns = sample_time * 1e9
        self._restart = RestartDetector()

    def arrival(self, stamp: int) -> Arrival:
        """Classify a stamp [ns] and store it if it is new; RESTARTED: the loop has restarted with this stamp."""
        last = self.last
        if stamp > last:
            if last >= 0:
                self.missed += round((stamp - last) / self._sample_ns) - 1
            self.last = stamp
            return Arrival.NEW
        if stamp == last:
            self.repeated += 1
            return Arrival.REPEATED
        self.old += 1
        return Arrival.RESTARTED if stamp == START_NS and self._restart.restarted(last) else Arrival.OLD
