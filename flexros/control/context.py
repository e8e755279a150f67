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

FURTHER_MEASUREMENTS: Mapping[str, str] = {
    "link_position": "a link-side encoder (sensors.link.position)",  # [rad or m]
    "joint_torque": "a joint torque sensor (sensors.link.torque)",  # [Nm or N]
    "tool_acceleration": "an accelerometer of the tool (sensors.tool_imu.acceleration)",  # [m/s2]
    "tool_turning_rate": "a gyroscope of the tool (sensors.tool_imu.turning_rate)",  # [rad/s]
}
"""Measured signals that a robot file may add to motor_position, each with the sensor that it takes."""

REFERENCES: Mapping[str, Callable[[Robot], int]] = {
    "motor_position": lambda robot: robot.n_motors,  # [rad or m]
    "motor_velocity": lambda robot: robot.n_motors,  # [rad/s or m/s]
    "feedforward_torque": lambda robot: robot.n_motors,  # [Nm or N]
}
"""Reference signals in the order in which the loop stacks them, each with its size."""


LINK_MOTION = ("link_position", "link_velocity", "link_acceleration", "link_jerk", "link_snap")
"""Further references of controllers that follow the motion of the links, M each [rad or m, per s^k]."""


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

    Measurements are the motor positions, then those of the sensors that the robot file states: `FURTHER_MEASUREMENTS`.
    To add a reference, add it to `REFERENCES`; existing laws are unaffected. The loop must supply the signal: see
    `flexros.scenario` and the controller node.

    Attributes:
        robot: The nominal robot: its model, linearisation, equilibria and torque limits.
        sample_time: Time between two samples [s].
        link_motion: Whether the references hold the motion of the links, `LINK_MOTION`.

    Raises:
        InputError: The sample time is not positive.
    """

    robot: Robot
    sample_time: float
    link_motion: bool = False

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
        further = {sensor.measurement: sensor.size for sensor in self.robot.further_sensors}
        return SignalLayout({"motor_position": self.robot.n_motors, **further})

    def require(self, *measurements: str) -> None:
        """Refuse a robot without the sensors that a control law needs at all its joints.

        Raises:
            InputError: Names robot, sensor and key of the robot file.
        """
        for name in measurements:
            size = self.measurements.sizes.get(name, 0)
            full = self.n_motors if name in ("motor_position", "link_position", "joint_torque") else 1
            if size < full:
                raise InputError(
                    f"the controller needs {FURTHER_MEASUREMENTS.get(name, name)}{' at every joint' * (full > 1)}, "
                    f"but robot {self.robot.name} has {size or 'none'}; add it to the robot file"
                )

    @property
    def references(self) -> SignalLayout:
        """Layout of the reference vector r."""
        links = dict.fromkeys(LINK_MOTION if self.link_motion else (), self.n_motors)
        return SignalLayout({name: size(self.robot) for name, size in REFERENCES.items()} | links)
