"""What the prediction takes from a log: command and motion of one motor, sample by sample."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from flexros.compile.command_delay import split_delay
from flexros.errors import InputError, unknown_name
from flexros.record.held_commands import EVEN, HeldCommands

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.identify.axis.structure import OutputQuantity
    from flexros.logs.time_series import JointSeries, Log

_SHORTEST = 200
"""Samples that a record must have (chosen)."""


@dataclass(frozen=True, eq=False)
class AxisRecord:
    """Evenly sampled signals of one motor.

    Attributes:
        label: Name of the log.
        quantity: What the output is.
        sample_time: T [s].
        torque: Commanded torque [Nm or N], shape (n,); that of sample k acts from k T + delay on.
        output: Measured position [rad or m] or speed [rad/s or m/s], shape (n,).
        delay: Delay of the command [s].
    """

    label: str
    quantity: OutputQuantity
    sample_time: float
    torque: FloatArray
    output: FloatArray
    delay: float

    @cached_property
    def position(self) -> FloatArray:
        """Position [rad or m], shape (n,): measured, or the sum of the speeds."""
        summed: FloatArray = self.sample_time * np.cumsum(self.output)
        return self.output if self.quantity == "position" else summed

    @cached_property
    def speed(self) -> FloatArray:
        """Speed [rad/s or m/s], shape (n,): measured, or by central differences."""
        if self.quantity == "velocity":
            return self.output
        speed: FloatArray = np.gradient(self.output, self.sample_time)
        return speed

    @property
    def rms_speed(self) -> float:
        """Rms speed [rad/s or m/s]."""
        return float(np.sqrt(np.mean(self.speed**2)))

    @property
    def rms_torque(self) -> float:
        """Rms torque [Nm or N]."""
        return float(np.sqrt(np.mean(self.torque**2)))

    @property
    def durations(self) -> tuple[float, ...]:
        """Lengths of the parts of a sample in which one command acts [s]."""
        return tuple(piece.duration for piece in split_delay(self.delay, self.sample_time).pieces)

    def inputs(self) -> FloatArray:
        """Put together what the predictor gets in each sample.

        Returns:
            The commands that act in the parts of a sample [Nm or N], then the output, shape (n, parts + 1).
        """
        pieces = split_delay(self.delay, self.sample_time).pieces
        place = np.arange(len(self.torque))
        commands = [self.torque[np.maximum(place - piece.age, 0)] for piece in pieces]
        return np.column_stack([*commands, self.output])


def axis_record(log: Log, joint: str, output: OutputQuantity, delay: float, label: str) -> AxisRecord:
    """Take the signals of one motor out of a log.

    Args:
        log: The log.
        joint: Name of the motor.
        output: What was measured.
        delay: Delay of the command [s].
        label: Name of the log; opens error texts.

    Returns:
        The record.

    Raises:
        InputError: Joint or signal are not in the log, or samples are missing, uneven, not finite or too few.
    """
    states, commands = log.joint_states, log.joint_commands
    measured = getattr(states, output)
    if measured is None:
        raise InputError(f"{label}: joint_states has no {output}, which is to be predicted; record it")
    if commands is None or commands.effort is None:
        raise InputError(f"{label} has no commanded torque (effort of joint_commands); record it")
    y = measured[:, _column(states, joint, f"{label}: joint_states")]
    sample_time = _interval(states, label)
    held = HeldCommands.of(commands.stamp, states.stamp)
    u = held.values(commands.effort[:, _column(commands, joint, f"{label}: joint_commands")])
    torque, motion = u[held.first :], y[held.first :]
    if len(torque) < _SHORTEST:
        raise InputError(f"{label} has {len(torque)} samples with a command, needed are {_SHORTEST}; give a longer log")
    for name, signal in ((output, motion), ("effort", torque)):
        if not np.all(np.isfinite(signal)):
            at = held.first + int(np.argmin(np.isfinite(signal)))
            raise InputError(f"{label}: {name} of {joint} is not finite in sample {at}; cut the log there")
    return AxisRecord(label, output, sample_time, torque.copy(), motion.copy(), delay)


def _column(series: JointSeries, joint: str, place: str) -> int:
    if joint not in series.names:
        raise unknown_name("joint", joint, series.names, place)
    return series.names.index(joint)


def _interval(states: JointSeries, label: str) -> float:
    steps = np.diff(states.stamp) * 1e-9
    if not len(steps):
        raise InputError(f"{label} has {len(states.stamp)} samples, needed are {_SHORTEST}; give a longer log")
    typical = float(np.mean(steps))
    worst = int(np.argmax(np.abs(steps - typical)))
    if abs(steps[worst] - typical) > EVEN * typical:
        time = (states.stamp[worst] - states.stamp[0]) * 1e-9
        raise InputError(
            f"{label}: the interval at {time:.6g} s is {1e3 * steps[worst]:.6g} ms instead of {1e3 * typical:.6g} ms; "
            "the prediction needs a log without gaps and of one rate: give such a log or a part of it"
        )
    return typical
