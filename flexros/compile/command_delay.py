"""Delay of the commands of all motors or of each, as whole samples and a fraction of a sample."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from flexros.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Sequence

_SAME = 1e-9  # a fraction this close to a whole sample is a rounding error of the division


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
class TorquePiece:
    """Part of a sample in which the commands of all motors are constant.

    Attributes:
        ages: How many samples old the command of each motor is, length M.
        duration: Length of the part [s].
    """

    ages: tuple[int, ...]
    duration: float


@dataclass(frozen=True)
class CommandDelay:
    """The command of sample k acts from t_k + delay on.

    Attributes:
        whole: Whole samples of the delay.
        fraction: Remainder as a fraction of a sample, in [0, 1).
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

    def torque_pieces(self, motors: int) -> tuple[TorquePiece, ...]:
        """Return the parts of every sample for a number of motors, whose commands all have this delay."""
        return tuple(TorquePiece((piece.age,) * motors, piece.duration) for piece in self.pieces)


@dataclass(frozen=True)
class MotorDelays:
    """The command of sample k acts at motor i from t_k + delay_i on.

    Attributes:
        delays: Delay of each motor, all of one sample time, length M.
    """

    delays: tuple[CommandDelay, ...]

    @property
    def line_length(self) -> int:
        """Number of past commands to remember."""
        return max(delay.line_length for delay in self.delays)

    def torque_pieces(self, motors: int) -> tuple[TorquePiece, ...]:
        """Return the parts of every sample, which end where the command of any motor changes."""
        assert motors == len(self.delays)
        sample_time = self.delays[0].sample_time
        cuts = sorted({delay.fraction * sample_time for delay in self.delays if delay.fraction > 0.0})
        parts = []
        for begin, end in zip((0.0, *cuts), (*cuts, sample_time)):
            ages = tuple(delay.whole + (1 if begin < delay.fraction * sample_time else 0) for delay in self.delays)
            parts.append(TorquePiece(ages, end - begin))
        return tuple(parts)


def split_delay(delay: float, sample_time: float) -> CommandDelay:
    """Split a delay into whole samples and a fraction of a sample.

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


def split_delays(delay: float | Sequence[float], sample_time: float) -> CommandDelay | MotorDelays:
    """Split one delay of all motors, or a delay of each, into whole samples and a fraction of a sample.

    Args:
        delay: Delay [s], zero or more: one number, or one for each motor.
        sample_time: Time between two samples [s].

    Raises:
        InputError: A delay negative or not finite, or sample time not positive.
    """
    if isinstance(delay, (int, float)):
        return split_delay(delay, sample_time)
    return MotorDelays(tuple(split_delay(motor_delay, sample_time) for motor_delay in delay))
