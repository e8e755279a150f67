"""The context of a control law: robot, sample time, and the signals of the loop by name."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

import casadi
import numpy as np

from flexros.arrays import ComplexArray, FloatArray
from flexros.errors import InputError, unknown_name

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from flexros.robot import Robot

Signal = TypeVar("Signal", FloatArray, ComplexArray, casadi.SX)
"""Samples, shape (..., size), or symbols, (size, 1)."""

MEASUREMENTS: Mapping[str, Callable[[Robot], int]] = {
    "motor_position": lambda robot: robot.n_motors,  # [rad or m]
}
"""Measured signals in the order in which the loop stacks them, each with its size."""

REFERENCES: Mapping[str, Callable[[Robot], int]] = {
    "motor_position": lambda robot: robot.n_motors,  # [rad or m]
    "motor_velocity": lambda robot: robot.n_motors,  # [rad/s or m/s]
    "feedforward_torque": lambda robot: robot.n_motors,  # [Nm or N]
}
"""Reference signals in the order in which the loop stacks them, each with its size."""


@dataclass(frozen=True)
class SignalLayout:
    """Named signals stacked in one vector.

    Attributes:
        sizes: Number of elements of each signal, in the order in which they are stacked.
    """

    sizes: Mapping[str, int]

    @property
    def size(self) -> int:
        """Number of elements of the whole vector."""
        return sum(self.sizes.values())

    def rows(self, name: str) -> slice:
        """Return the rows of one signal.

        Raises:
            InputError: The loop has no signal of this name.
        """
        if name not in self.sizes:
            raise unknown_name("signal of the loop", name, self.sizes)
        names = list(self.sizes)
        begin = sum(self.sizes[before] for before in names[: names.index(name)])
        return slice(begin, begin + self.sizes[name])

    def part(self, vector: Signal, name: str) -> Signal:
        """Extract one signal.

        Args:
            vector: All signals, samples of shape (..., size) or symbols (size, 1).
            name: Name of the signal.

        Returns:
            The signal, shape (..., its size) or (its size, 1).

        Raises:
            InputError: The loop has no signal of this name.
        """
        rows = self.rows(name)
        return vector[rows] if isinstance(vector, casadi.SX) else vector[..., rows]

    def stack(self, signals: Mapping[str, FloatArray]) -> FloatArray:
        """Stack one array of samples per signal, each of shape (..., its size), to shape (..., size)."""
        return np.concatenate([signals[name] for name in self.sizes], axis=-1)

    def element(self, row: int) -> tuple[str, int]:
        """Return signal and index within it of one row of the vector."""
        for name, size in self.sizes.items():
            if row < size:
                return name, row
            row -= size
        raise IndexError(row)


@dataclass(frozen=True, eq=False)
class LoopContext:
    """Context from which a control law is built.

    To add a sensor or reference derivative, add it to `MEASUREMENTS` or `REFERENCES`; existing laws are unaffected. The
    loop must supply the signal: see `flexros.scenario` and the controller node.

    Attributes:
        robot: The nominal robot: its model, linearisation, equilibria and torque limits.
        sample_time: Time between two samples [s].

    Raises:
        InputError: The sample time is not positive.
    """

    robot: Robot
    sample_time: float

    def __post_init__(self) -> None:
        if not (math.isfinite(self.sample_time) and self.sample_time > 0.0):
            raise InputError(f"sample time of the controller is {self.sample_time} s, but must be positive; correct it")

    @property
    def n_motors(self) -> int:
        """Number of motors, M."""
        return self.robot.n_motors

    @property
    def measurements(self) -> SignalLayout:
        """Layout of the measurement vector y."""
        return SignalLayout({name: size(self.robot) for name, size in MEASUREMENTS.items()})

    @property
    def references(self) -> SignalLayout:
        """Layout of the reference vector r."""
        return SignalLayout({name: size(self.robot) for name, size in REFERENCES.items()})
