"""The cycles of a plant in real time: a schedule, and the newest command for each cycle; free of ROS."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros_nodes.protocol.loop.loop_figures import timing_figures
from flexros_nodes.protocol.real_time.held_command import HeldCommand
from flexros_nodes.protocol.real_time.schedule import Schedule

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.arrays import FloatArray
    from flexros_nodes.protocol.real_time.schedule import PeriodStatistics


MOST_MESSAGES = 100
"""Messages that are looked through for a command, chosen: anybody may send more than one takes."""


class PlantPacing:
    """Paces the loop by the wall clock: it never waits, holds the last command and counts the miss.

    Args:
        on_cycle: Called with the command of the sample that is due [Nm or N], shape (M,); None when the last one that
            came is too old.
        receive: Takes one message that has come, which may `offer` its command; tells whether there was one.

    Attributes:
        prioritised: Whether the thread that paces has real-time priority; set by whoever spins.
        schedule: Due times, None while there is nothing to pace: in lock-step, before the first sample and in a pause.
    """

    def __init__(
        self, on_cycle: Callable[[FloatArray | None], None], receive: Callable[[], bool] = lambda: False
    ) -> None:
        self.prioritised = False
        self.schedule: Schedule | None = None
        self._on_cycle = on_cycle
        self._receive = receive
        self._newest: HeldCommand | None = None

    @property
    def has_begun(self) -> bool:
        """Whether the first command is there, so that the loop is led by its cycles."""
        return self._newest is not None

    def answered(self) -> bool:
        """Look whether the command of the present sample has come; also true when no answer is awaited."""
        return self._newest is None or self.schedule is None or self._look(self._newest)

    def _look(self, held: HeldCommand) -> bool:
        """Take what has come until it is the command of the present sample; tells whether that is there."""
        for _ in range(MOST_MESSAGES):
            if held.is_new or not self._receive():
                break
        return held.is_new

    def begin(self, first: FloatArray, sample_time: float, patience: float) -> None:
        """Take the command of the first sample; `go_on` lets the cycles follow.

        Args:
            first: The command [Nm or N], shape (M,).
            sample_time: Time between two samples [s].
            patience: Time for which a command is held [s].
        """
        self._newest = HeldCommand(first, sample_time, patience)
        self._cycles = Schedule(sample_time)
        self._sample_time = sample_time

    def go_on(self, now: float) -> None:
        """Begin the schedule, or begin it anew after a pause, with a cycle one sample time from now [s]."""
        self._cycles.begin(now + self._sample_time)
        self.schedule = self._cycles

    def halt(self) -> None:
        """Let no cycle follow."""
        self.schedule = None

    def forget(self) -> None:
        """Stand before the first command."""
        self.schedule = self._newest = None

    def offer(self, command: FloatArray, *, late: bool = False) -> None:
        """Take a command that has come [Nm or N], shape (M,); a late one answers a sample that is over."""
        if self._newest is not None:
            self._newest.offer(command, late=late)

    def cycle(self) -> None:
        """Do the cycle that is due, unless a pause has come since."""
        if self.schedule is not None:
            self.step()

    def step(self) -> None:
        """Do one cycle, at no special time."""
        if (held := self._newest) is not None:
            self._look(held)
            self._on_cycle(held.take())

    def figures(self, sum_up: Callable[[Schedule], PeriodStatistics | None]) -> dict[str, float]:
        """Give how well the schedule was kept, as `timing_figures` names it."""
        cycles = None if self._newest is None else sum_up(self._cycles)
        return timing_figures(self.prioritised, self._newest, cycles)
