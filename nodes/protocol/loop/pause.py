"""Pause of the loop, with single steps."""

from __future__ import annotations


class Pause:
    """State of a pause that single samples may pass.

    Args:
        on: Whether the loop is paused from the beginning.
        now: Wall-clock time [s], any origin.

    Attributes:
        on: Whether the loop is paused, except for single steps.
        step_is_due: Whether one more sample passes during the pause.
        since: Time at which the pause or its last step began [s].
    """

    def __init__(self, on: bool, now: float) -> None:
        self.on = on
        self.step_is_due = False
        self.since = now

    @property
    def holds(self) -> bool:
        """Whether the loop must wait."""
        return self.on and not self.step_is_due

    def begin(self, now: float) -> None:
        """Pause the loop from now on [s]."""
        self.on, self.since = True, now

    def end(self, now: float) -> float:
        """Resume the loop; return the time since the pause or its last step began [s]."""
        self.on = self.step_is_due = False
        return now - self.since

    def step(self) -> None:
        """Let one more sample pass."""
        self.step_is_due = True

    def passed(self, now: float) -> float:
        """Count a sample that passes now [s]; return the paused time before it [s]."""
        paused = now - self.since if self.on else 0.0
        self.step_is_due = False
        self.since = now
        return paused
