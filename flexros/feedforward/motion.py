"""Results of feedforward: the motion of the model, and the reference computed from it."""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from flexros.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class Motion:
    """Motion and torque of the model at the sampling instants, before compensation of friction and hold.

    Attributes:
        arm_position: Arm coordinates q_a [rad or m], shape (n, N).
        motor_position: Encoder positions [rad or m], shape (n, M).
        motor_velocity: Encoder velocities [rad/s or m/s], shape (n, M).
        torque: Motor torque at the instant [Nm or N], shape (n, M).
        load: Torque without the part that accelerates the motor's own inertia [Nm or N], shape (n, M).
        momentum: Momentum of the motor's own inertia [Nms or Ns], zero behind stiff gears, shape (n, M). The torque is
            the load plus the rate of change of the momentum.
    """

    arm_position: FloatArray
    motor_position: FloatArray
    motor_velocity: FloatArray
    torque: FloatArray
    load: FloatArray
    momentum: FloatArray

    def __len__(self) -> int:
        return len(self.torque)

    def without_torque(self) -> Motion:
        """Return the same motion with all torques zero."""
        zero = np.zeros_like(self.torque)
        return replace(self, torque=zero, load=zero, momentum=zero)

    def with_friction(self, friction: FloatArray) -> Motion:
        """Return the same motion with a friction torque [Nm or N], shape (n, M), added."""
        return replace(self, torque=self.torque + friction, load=self.load + friction)

    def chunks(self, size: int) -> Iterator[Motion]:
        """Yield successive parts of at most `size` samples."""
        for first in range(0, len(self), size):
            yield self.rows(first, first + size)

    def rows(self, first: int, stop: int) -> Motion:
        """Return the samples first, ..., stop - 1."""
        return Motion(*(getattr(self, entry.name)[first:stop] for entry in fields(self)))

    def joined(self, after: Motion) -> Motion:
        """Return this motion followed by another one."""
        return Motion.concatenate([self, after])

    @staticmethod
    def concatenate(parts: Sequence[Motion]) -> Motion:
        """Join successive parts, at least one."""
        return Motion(*(np.concatenate([getattr(part, f.name) for part in parts]) for f in fields(Motion)))


@dataclass(frozen=True, eq=False)
class Reference:
    """References and feedforward torque, one row per sampling instant.

    Attributes:
        time: Sampling instants, counted from the start of the motion [s], shape (n,).
        motor_position: Encoder position that the feedback controls to [rad or m], shape (n, M).
        motor_velocity: Its rate [rad/s or m/s], shape (n, M).
        torque: Motor torque to add to the feedback, held from its instant to the next [Nm or N], shape (n, M).
        output: Commanded value of the controlled output [m or rad], shape (n, n_out).
        tool_pose: Commanded tool pose: x, y, z [m] and quaternion x, y, z, w, shape (n, 7).
        link_motion: Position of the links behind the gears, as of the rigid arm on the trajectory, and its first four
            derivatives [rad or m, per s^k], shape (n, 5, M), for controllers that follow it; else empty, (n, 0, 0).
    """

    time: FloatArray
    motor_position: FloatArray
    motor_velocity: FloatArray
    torque: FloatArray
    output: FloatArray
    tool_pose: FloatArray
    link_motion: FloatArray = field(default_factory=lambda: np.zeros((0, 0, 0)))

    def __post_init__(self) -> None:
        if not self.link_motion.size:
            object.__setattr__(self, "link_motion", np.zeros((len(self.time), 0, 0)))
        lengths = {entry.name: len(getattr(self, entry.name)) for entry in fields(self)}
        if len(set(lengths.values())) != 1:
            raise ValueError(f"the arrays of a reference need the same number of rows, but have {lengths}")

    def __len__(self) -> int:
        return len(self.time)

    @staticmethod
    def concatenate(chunks: Sequence[Reference]) -> Reference:
        """Join successive chunks, at least one."""
        return Reference(*(np.concatenate([getattr(chunk, f.name) for chunk in chunks]) for f in fields(Reference)))
