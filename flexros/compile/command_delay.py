"""Delay of the command, any time from zero on, as whole samples and a fraction of one."""

from __future__ import annotations

import math
from dataclasses import dataclass

from flexros.errors import InputError

_SAME = 1e-9  # a fraction this close to a whole sample is rounding of the division


@dataclass(frozen=True)
class CommandPiece:
    """Part of a sample with constant command.

    Attributes:
        age: How many samples old the command is: 0 is the command of this sample.
        duration: Length of the part [s].
    """

    age: int
    duration: float


@dataclass(frozen=True)
class CommandDelay:
    """The command of sample k acts from t_k + delay on.

    Attributes:
        whole: Whole samples of the delay.
        fraction: The rest, as a fraction of a sample, 0 or more and less than 1.
        sample_time: Time between two samples [s].
    """

    whole: int
    fraction: float
    sample_time: float

    @property
    def line_length(self) -> int:
        """Number of past commands to remember."""
        return self.whole + (1 if self.fraction > 0.0 else 0)

    @property
    def pieces(self) -> tuple[CommandPiece, ...]:
        """The parts of every sample, one or two."""
        if self.fraction == 0.0:
            return (CommandPiece(self.whole, self.sample_time),)
        old = CommandPiece(self.whole + 1, self.fraction * self.sample_time)
        return old, CommandPiece(self.whole, self.sample_time - old.duration)


def split_delay(delay: float, sample_time: float) -> CommandDelay:
    """Split a delay into whole samples and a fraction of one.

    Args:
        delay: Delay [s], zero or more.
        sample_time: Time between two samples [s].

    Raises:
        InputError: Delay negative or not finite, or sample time not positive.
    """
    if not (math.isfinite(sample_time) and sample_time > 0.0):
        raise InputError(f"sample time {sample_time} s is not possible: it must be positive")
    if not (math.isfinite(delay) and delay >= 0.0):
        raise InputError(f"command delay {delay} s is not possible: it must be zero or positive")
    samples = delay / sample_time
    whole = math.floor(samples + _SAME)
    fraction = samples - whole
    return CommandDelay(whole, fraction if fraction > _SAME else 0.0, sample_time)
