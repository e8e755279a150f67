"""Bookkeeping of the lock-step protocol, free of ROS: which stamp is awaited, what is sent again, who gave up.

The plant publishes the measurement with stamp k T and goes on only when the command with the same stamp has come. The
controller answers each stamp once, repeats its last reply for a repeated stamp and drops older ones. So the data, not
the timing, decide what follows, and a run is the same in every executor, process layout and speed.
"""

from __future__ import annotations

from enum import Enum, auto

from flexros.logs.stamps import START_NS

HANDSHAKE_PERIOD = 0.1
"""Time after which state 0 is sent again while the partners find each other [s], chosen."""

FASTEST_RESEND = 0.002
"""Shortest time after which a state is sent again [s], chosen: ten times what a round trip takes."""

ROUND_TRIPS = 5.0
"""Round trips after which a state counts as lost, chosen."""

FORGETTING = 0.98
"""Share of a slow round trip that a tick remembers, chosen: half of it is forgotten after 34."""


FIRST_SAMPLE_AGAIN = 3
"""Times that the first sample must come again before a loop counts as begun anew, chosen: one may be a late repeat."""


class Tick(Enum):
    """What the plant has to do when its watch timer fires."""

    WAIT = auto()
    RESEND = auto()
    GIVE_UP = auto()


class Arrival(Enum):
    """What a stamp means to the controller that receives it."""

    NEW = auto()
    REPEATED = auto()
    OLD = auto()
    ANEW = auto()


class Beginning:
    """Tells a loop that has begun anew from a late repeat of its first sample.

    A plant that stands before its first sample repeats it until it is answered. So it has begun anew when the first
    stamp comes several times while nothing newer does.
    """

    def __init__(self) -> None:
        self._count = 0
        self._newest = -1

    def is_new(self, newest: int) -> bool:
        """Note that the first stamp has come again; tells whether the loop has begun anew.

        Args:
            newest: Newest stamp or sample that is known.
        """
        self._count = self._count + 1 if newest == self._newest else 1
        self._newest = newest
        return self._count >= FIRST_SAMPLE_AGAIN


class PlantLockStep:
    """The plant's side: one state in flight, sent again after a time-out, given up after a longer one.

    The watch timer calls `tick` at a fixed period. A state counts as unanswered when it has been in flight for at least
    one whole period, so that nothing in the hot path has to read a clock. The time-out follows the round trips that
    the ticks see, and doubles with every repeat.

    Args:
        tick_period: Period of the watch timer [s].
        resend_timeout: Longest time after which a state is sent again [s].
        partner_timeout: Time without an answer after which the partner counts as gone [s].
        start_timeout: The same for the first state, while nodes still start [s].

    Attributes:
        awaited: Stamp of the state in flight [ns], -1 before the first.
        resends: States sent again after the first reply.
        handshakes: Times that the first state was sent again.
        stale: Commands that came for another stamp than the one in flight: repeats, or too late in real time.
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
        self._doubtful = 0.0
        self._silence = 0.0
        self._since_sent = 0.0

    @property
    def silence(self) -> float:
        """Time since the watch timer saw the state in flight for the first time [s]."""
        return self._silence

    def sent(self, stamp: int) -> None:
        """Note that the state with this stamp [ns] is in flight."""
        self._started = self._started or self.awaited >= 0
        self.awaited = stamp
        self._n_sent += 1

    def answers(self, stamp: int) -> bool:
        """Tell whether a command's stamp [ns] answers the state in flight; counts it as stale if not."""
        if stamp == self.awaited:
            return True
        self.stale += 1
        # a second answer: the state was not lost, its round trip was merely longer
        slow = self._silence + self._tick_period if self._repeats else self._doubtful
        self._round_trip = max(self._round_trip, slow)
        self._doubtful = 0.0
        return False

    def hold(self) -> None:
        """Start the silence anew: the plant itself keeps the loop waiting."""
        self._seen = -1
        self._n_sent = 0  # what the plant waited is no round trip

    def tick(self) -> Tick:
        """Decide what to do, once per period of the watch timer."""
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
        if self._since_sent < self._patience() * (1.0 - 1e-9):
            return Tick.WAIT
        self._since_sent = 0.0
        self._repeats += 1
        if self._started:
            self.resends += 1
        else:
            self.handshakes += 1
        return Tick.RESEND

    def _patience(self) -> float:
        """Give the time after which the state in flight is sent again [s]."""
        if not self._started:
            return HANDSHAKE_PERIOD
        longer = max(ROUND_TRIPS * self._round_trip, FASTEST_RESEND) * 2.0 ** min(self._repeats, 20)
        return min(longer, self._resend_timeout)

    def _learn(self) -> None:
        """Take the mean round trip since the tick before; a state that was sent twice tells none as yet."""
        time = self._silence + self._tick_period
        if self._repeats:
            self._doubtful = time
        elif self._n_sent and self._started:
            self._round_trip = max(time / self._n_sent, FORGETTING * self._round_trip)


class ControllerLockStep:
    """The controller's side: what an arriving stamp means.

    Args:
        sample_time: Time between two samples [s].

    Attributes:
        last: Newest stamp [ns], -1 before the first.
        repeated: States that came again.
        old: States older than the newest, dropped.
        missed: Samples skipped between two new states; none in lock-step.
    """

    def __init__(self, sample_time: float) -> None:
        self.last = -1
        self.repeated = 0
        self.old = 0
        self.missed = 0
        self._sample_ns = sample_time * 1e9
        self._beginning = Beginning()

    def arrival(self, stamp: int) -> Arrival:
        """Classify a stamp [ns] and remember it when it is new; ANEW says that the loop has begun anew with it."""
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
        return Arrival.ANEW if stamp == START_NS and self._beginning.is_new(last) else Arrival.OLD
