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
        pieces: The parts of every sample, one or two.
        line_length: Number of past commands to remember.
    """

    pieces: tuple[CommandPiece, ...]
    line_length: int


def split_delay(delay: float, sample_time: float) -> CommandDelay:
    """Split a delay into remembered commands and the parts of a sample.

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
    whole = math.floor(delay / sample_time + _SAME)
    fraction = delay / sample_time - whole
    if fraction <= _SAME:
        return CommandDelay((CommandPiece(whole, sample_time),), whole)
    old = CommandPiece(whole + 1, fraction * sample_time)
    return CommandDelay((old, CommandPiece(whole, sample_time - old.duration)), whole + 1)
