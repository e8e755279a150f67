"""Command and motion of one motor, sample by sample."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from flexros.compile.command_delay import split_delay
from flexros.errors import InputError
from flexros.record.missing_samples import MOST_BRIDGED, bridged_motion, long_holes, runs

if TYPE_CHECKING:
    from flexros.arrays import BoolArray, FloatArray
    from flexros.identify.axis.structure import OutputQuantity
    from flexros.record.record import Record

_SHORTEST = 200
"""Fewest samples of a record (chosen)."""


@dataclass(frozen=True, eq=False)
class AxisRecord:
    """Evenly sampled signals of one motor.

    Attributes:
        label: Name of the log.
        quantity: Quantity of the output.
        sample_time: T [s].
        torque: Torque [Nm or N], shape (n,); a command of sample k acts from k T + delay on.
        output: Position [rad or m] or speed [rad/s or m/s], bridged where it was not measured, shape (n,).
        delay: Delay of the command [s]; zero where the torque was measured.
        valid: Whether a sample was measured, shape (n,); None where all were.
        warnings: What was repaired or is doubtful, one sentence each.
    """

    label: str
    quantity: OutputQuantity
    sample_time: float
    torque: FloatArray
    output: FloatArray
    delay: float
    valid: BoolArray | None = None
    warnings: tuple[str, ...] = ()

    @cached_property
    def position(self) -> FloatArray:
        """Position [rad or m], shape (n,): measured, or the integral of the speed."""
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
        """Return the inputs of the predictor in each sample.

        Returns:
            Commands that act in the parts of a sample [Nm or N], then the output, shape (n, parts + 1).
        """
        pieces = split_delay(self.delay, self.sample_time).pieces
        row = np.arange(len(self.torque))
        commands = [self.torque[np.maximum(row - piece.age, 0)] for piece in pieces]
        return np.column_stack([*commands, self.output])

    def of_measured(self, values: FloatArray) -> FloatArray:
        """Set values, shape (n, ...), to zero in samples that were not measured."""
        if self.valid is None:
            return values
        return values * self.valid.reshape(-1, *[1] * (values.ndim - 1))


def axis_record(record: Record, motor: int, output: OutputQuantity, delay: float) -> AxisRecord:
    """Select the signals of one motor.

    Short holes are bridged. Of a record with long ones the longest stretch without is taken.

    Args:
        record: Record of the log.
        motor: Number of the motor (0-based).
        output: Quantity of the output.
        delay: Delay of the command [s].

    Returns:
        The signals.

    Raises:
        InputError: The output was not recorded, or there are too few samples.
    """
    measured = record.position if output == "position" else record.velocity
    if measured is None or not np.isfinite(measured[:, motor]).any():
        raise InputError(
            f"{record.name}: joint_states has no {output} of motor_{motor + 1}, which is to be predicted; record it"
        )
    begin, length = runs(~long_holes(record.valid))
    longest = int(np.argmax(length)) if len(length) else 0
    rows = slice(begin[longest], begin[longest] + length[longest]) if len(length) else slice(0, 0)
    n = rows.stop - rows.start
    if n < _SHORTEST:
        raise InputError(
            f"{record.name} has {n} samples in a row with position and torque, at least {_SHORTEST} are needed; give "
            "a longer log"
        )
    if np.ptp(bridged_motion(record.position[rows, motor : motor + 1], record.valid[rows])) == 0:
        raise InputError(
            f"{record.name}: motor_{motor + 1} stands still, so nothing shows its masses and friction; name the joint "
            "that moves, or give a log in which this one does"
        )
    warnings = record.warnings
    if n < record.n_samples:
        warnings += (
            f"more than {MOST_BRIDGED} samples in a row are missing; of the {record.n_samples} samples the longest "
            f"stretch without such a hole is used, {n} from sample {rows.start} on",
        )
    valid = record.valid[rows]
    return AxisRecord(
        label=record.name,
        quantity=output,
        sample_time=record.sample_time,
        torque=record.torque[rows, motor].copy(),
        output=bridged_motion(measured[rows, motor : motor + 1], valid)[:, 0].copy(),
        delay=0.0 if record.measured_torque else delay,
        valid=None if valid.all() else valid,
        warnings=warnings,
    )
