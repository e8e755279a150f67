"""What control laws have in common that treat each motor for itself."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING, ClassVar, TypeAlias

import casadi
import numpy as np
from pydantic import Field

from flexros.config.per_motor import NotNegativePerMotor, PositivePerMotor, per_motor
from flexros.control.anti_windup import limit_with_integral
from flexros.control.base import AbstractControlLaw

if TYPE_CHECKING:
    from flexros.arrays import FloatArray

Gain: TypeAlias = NotNegativePerMotor
"""A gain, one for all motors or one per motor."""


class AbstractMotorwiseLaw(AbstractControlLaw):
    """A law with the same gains for each motor, an integral part, and a limit of the command.

    How to add one: name the fields that are gains in `gain_keys`, and write `update`. The state is
    [previous value (M), filtered rate (M), integral part (M), started]; all arithmetic is motor by motor.
    """

    gain_keys: ClassVar[tuple[str, ...]]
    lowest_gain: ClassVar[float] = 0.0

    torque_limit: PositivePerMotor | None = Field(
        default=None, description="limit of the command [Nm], one or one per motor; the robot's own where left out"
    )

    @abstractmethod
    def update(
        self,
        reference: tuple[casadi.SX, casadi.SX, casadi.SX],
        position: casadi.SX,
        gains: tuple[casadi.SX, ...],
        before: tuple[casadi.SX, casadi.SX, casadi.SX],
        sample_time: float,
    ) -> tuple[casadi.SX, casadi.SX, casadi.SX, casadi.SX]:
        """Compute one sample of all motors; every vector has shape (M, 1).

        Args:
            reference: Motor position, velocity and feedforward torque.
            position: Measured motor position.
            gains: The gains of `gain_keys`, in that order.
            before: Previous value, filtered rate, and a flag that is true from the second sample on.
            sample_time: Time between two samples [s].

        Returns:
            Command without its integral part, increment of the integral part, value and filtered rate to remember.
        """

    def state_size(self, n_motors: int) -> int:
        """Give the number of memory variables, 3 M + 1."""
        return 3 * n_motors + 1

    def gain_names(self, n_motors: int) -> tuple[str, ...]:
        """Name the gains: those of `gain_keys`, then torque_limit, each for all motors, e.g. "motor_1.kp"."""
        keys = (*self.gain_keys, "torque_limit")
        return tuple(f"motor_{motor}.{key}" for key in keys for motor in range(1, n_motors + 1))

    def gains(self, n_motors: int, torque_limits: FloatArray | None = None) -> FloatArray:
        """Give the gain vector; the torque limit is the lower one of the setting and the robot's."""
        limits = np.full(n_motors, np.inf) if torque_limits is None else np.asarray(torque_limits, dtype=float)
        if self.torque_limit is not None:
            limits = np.minimum(limits, per_motor("controller.torque_limit", self.torque_limit, n_motors))
        gains = (per_motor(f"controller.{key}", getattr(self, key), n_motors) for key in self.gain_keys)
        return np.concatenate([*gains, limits])

    def function(self, n_motors: int, sample_time: float) -> casadi.Function:
        """Build the update `(c, r, y, g) -> (u, c_next)` as a CasADi SX function."""
        state = casadi.SX.sym("c", self.state_size(n_motors))
        reference = casadi.SX.sym("r", 3 * n_motors)
        position = casadi.SX.sym("y", n_motors)
        gains = casadi.SX.sym("g", (len(self.gain_keys) + 1) * n_motors)
        value_before, rate_before, integral_before = casadi.vertsplit(state[:-1], n_motors)
        target, target_speed, feedforward = casadi.vertsplit(reference, n_motors)
        *factors, limit = casadi.vertsplit(gains, n_motors)
        rest, increment, value, rate = self.update(
            (target, target_speed, feedforward),
            position,
            tuple(factors),
            (value_before, rate_before, state[-1] > 0.5),
            sample_time,
        )
        command, integral = limit_with_integral(rest, integral_before, increment, limit)
        return casadi.Function(
            self.kind,
            [state, reference, position, gains],
            [command, casadi.vertcat(value, rate, integral, casadi.SX(1.0))],
            ["c", "r", "y", "g"],
            ["u", "c_next"],
        )
