"""The command of a plant in real time, which never waits: the newest that came, else the last one; free of ROS."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from flexros.arrays import FloatArray


class HeldCommand:
    """Holds the last command while no new one comes, for a while.

    A partner that answers late is not gone: its command is held, too, but the sample that it answers was missed.

    Args:
        first: Command of the first sample [Nm or N], shape (M,).
        sample_time: Time between two samples [s].
        patience: Time for which a command is held [s].

    Attributes:
        missed: Samples for which no command had come in time.
    """

    def __init__(self, first: FloatArray, sample_time: float, patience: float) -> None:
        self.missed = 0
        self._command = first
        self._is_new = True
        self._most = max(round(patience / sample_time), 1)
        self._in_a_row = 0

    @property
    def is_new(self) -> bool:
        """Whether a command has come that was not taken yet."""
        return self._is_new

    def offer(self, command: FloatArray, *, late: bool = False) -> None:
        """Take a command that has come [Nm or N], shape (M,); a late one answers a sample that is over."""
        self._command = command
        self._is_new = not late
        self._in_a_row = 0

    def take(self) -> FloatArray | None:
        """Give the command of the sample that is due, shape (M,); None when the last one is too old."""
        if self._is_new:
            self._is_new = False
            self._in_a_row = 0
            return self._command
        self.missed += 1
        self._in_a_row += 1
        return self._command if self._in_a_row <= self._most else None
