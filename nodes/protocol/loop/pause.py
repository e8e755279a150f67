"""Whether a loop stands still because its user wants it so; free of ROS."""

from __future__ import annotations


class Pause:
    """A pause that may let single samples pass.

    Args:
        on: Whether the loop stands still from the beginning.
        now: Time of the wall clock [s], any origin.

    Attributes:
        on: Whether the loop stands still, but for steps.
        step_is_due: Whether one more sample is to follow in the pause.
        since: When the pause, or its last step, was [s].
    """

    def __init__(self, on: bool, now: float) -> None:
        self.on = on
        self.step_is_due = False
        self.since = now

    @property
    def holds(self) -> bool:
        """Whether nothing may follow."""
        return self.on and not self.step_is_due

    def begin(self, now: float) -> None:
        """Let the loop stand still from now on [s]."""
        self.on, self.since = True, now

    def end(self, now: float) -> float:
        """Let the loop go on; gives for how long it has stood still [s]."""
        self.on = self.step_is_due = False
        return now - self.since

    def step(self) -> None:
        """Let one more sample pass."""
        self.step_is_due = True

    def passed(self, now: float) -> float:
        """Note that a sample passes now [s]; gives for how long the loop has stood still before it [s]."""
        stood = now - self.since if self.on else 0.0
        self.step_is_due = False
        self.since = now
        return stood
