"""Real-time cycles of the plant: a schedule, and the command held for each cycle."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros_nodes.protocol.real_time.schedule import Schedule

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.arrays import FloatArray
    from flexros_nodes.protocol.real_time.schedule import PeriodStatistics


MOST_MESSAGES = 100
"""Messages searched for a command per cycle, chosen: any node may publish more than a cycle can process."""


class HeldCommand:
    """Holds the last command for a limited time while no new one arrives.

    A partner that answers late is not gone: its command is held too, but the sample that it answers counts as missed.

    Args:
        first: Command of the first sample [Nm or N], shape (M,).
        sample_time: Time between two samples [s].
        patience: Longest time for which a command is held [s].

    Attributes:
        missed: Samples for which no command had arrived in time.
    """

    def __init__(self, first: FloatArray, sample_time: float, patience: float) -> None:
        self.missed = 0
        self._command = first
        self._is_new = True
        self._most_in_a_row = max(round(patience / sample_time), 1)
        self._in_a_row = 0

    @property
    def is_new(self) -> bool:
        """Whether a command has arrived that was not applied yet."""
        return self._is_new

    def offer(self, command: FloatArray, *, late: bool = False) -> None:
        """Store a received command [Nm or N], shape (M,); a late one answers a past sample."""
        self._command = command
        self._is_new = not late
        self._in_a_row = 0

    def take(self) -> FloatArray | None:
        """Return the command of the sample that is due, shape (M,); None when the last one is too old."""
        if self._is_new:
            self._is_new = False
            self._in_a_row = 0
            return self._command
        self.missed += 1
        self._in_a_row += 1
        return self._command if self._in_a_row <= self._most_in_a_row else None


class PlantPacing:
    """Paces the loop by the wall clock: it never waits, holds the last command and counts the miss.

    Args:
        on_cycle: Called with the command of the sample that is due [Nm or N], shape (M,); None when the last received
            one is too old.
        receive: Processes one received message, which may `offer` its command; returns whether there was one.

    Attributes:
        prioritised: Whether the pacing thread has real-time priority; set by the spinning loop.
        schedule: Due times; None while nothing is paced: in lock-step, before the first sample and in a pause.
    """

    def __init__(
        self, on_cycle: Callable[[FloatArray | None], None], receive: Callable[[], bool] = lambda: False
    ) -> None:
        self.prioritised = False
        self.schedule: Schedule | None = None
        self._on_cycle = on_cycle
        self._receive = receive
        self._held: HeldCommand | None = None

    @property
    def has_begun(self) -> bool:
        """Whether the first command has arrived, so that cycles drive the loop."""
        return self._held is not None

    def answered(self) -> bool:
        """Return whether the command of the present sample has arrived; also true when none is awaited."""
        return self._held is None or self.schedule is None or self._receive_new(self._held)

    def _receive_new(self, held: HeldCommand) -> bool:
        """Process received messages up to the command of the present sample; return whether it has arrived."""
        for _ in range(MOST_MESSAGES):
            if held.is_new or not self._receive():
                break
        return held.is_new

    def begin(self, first: FloatArray, sample_time: float, patience: float) -> None:
        """Store the command of the first sample; `go_on` starts the cycles.

        Args:
            first: The command [Nm or N], shape (M,).
            sample_time: Time between two samples [s].
            patience: Longest time for which a command is held [s].
        """
        self._held = HeldCommand(first, sample_time, patience)
        self._cycles = Schedule(sample_time)
        self._sample_time = sample_time

    def go_on(self, now: float) -> None:
        """Start the schedule, or restart it after a pause, with a cycle one sample time from now [s]."""
        self._cycles.begin(now + self._sample_time)
        self.schedule = self._cycles

    def halt(self) -> None:
        """Stop the cycles."""
        self.schedule = None

    def reset(self) -> None:
        """Return to the state before the first command."""
        self.schedule = self._held = None

    def offer(self, command: FloatArray, *, late: bool = False) -> None:
        """Store a received command [Nm or N], shape (M,); a late one answers a past sample."""
        if self._held is not None:
            self._held.offer(command, late=late)

    def cycle(self) -> None:
        """Execute the cycle that is due, unless a pause has begun since."""
        if self.schedule is not None:
            self.step()

    def step(self) -> None:
        """Execute one cycle, independent of the schedule."""
        if (held := self._held) is not None:
            self._receive_new(held)
            self._on_cycle(held.take())

    def figures(self, statistics_of: Callable[[Schedule], PeriodStatistics | None]) -> dict[str, float]:
        """Return how well the schedule was kept, by diagnostics key; missed commands count from the first cycle on."""
        statistics = None if self._held is None else statistics_of(self._cycles)
        if self._held is None or statistics is None:
            return {"missed_commands": 0, "real_time_priority": self.prioritised}
        return {
            "missed_commands": self._held.missed,
            "real_time_priority": self.prioritised,
            **statistics.as_dict(),
        }
