"""Base of control laws that control each motor separately: gains per motor, integral part, torque limit."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING, TypeAlias

import casadi

from flexros.config.per_motor import NotNegativePerMotor
from flexros.control.limited import AbstractLimitedLaw

if TYPE_CHECKING:
    from flexros.control.context import LoopContext

Gain: TypeAlias = NotNegativePerMotor
"""A gain, one for all motors or one per motor."""


class AbstractMotorwiseLaw(AbstractLimitedLaw):
    """A decentralised law with gains per motor, an integral part and a limited command.

    How to add one: list the fields that are gains in `gain_keys` and write `update`. The state is
    [previous value (M), filtered rate (M), integral part (M), started]; all arithmetic is elementwise.
    """

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
            Command without its integral part, increment of the integral part, value and filtered rate to store.
        """

    def state_size(self, context: LoopContext) -> int:
        """Return the number of states, 3 M + 1."""
        return 3 * context.n_motors + 1

    def function(self, context: LoopContext) -> casadi.Function:
        """Build the update `(c, r, y, g) -> (u, c_next)` as a CasADi SX function."""
        n_motors, references, measurements = context.n_motors, context.references, context.measurements
        state = casadi.SX.sym("c", self.state_size(context))
        reference = casadi.SX.sym("r", references.size)
        measured = casadi.SX.sym("y", measurements.size)
        gains = casadi.SX.sym("g", (len(self.gain_keys) + 1) * n_motors)
        value_before, rate_before, integral_before = casadi.vertsplit(state[:-1], n_motors)
        *factors, limit = casadi.vertsplit(gains, n_motors)
        rest, increment, value, rate = self.update(
            (
                references.part(reference, "motor_position"),
                references.part(reference, "motor_velocity"),
                references.part(reference, "feedforward_torque"),
            ),
            measurements.part(measured, "motor_position"),
            tuple(factors),
            (value_before, rate_before, state[-1] > 0.5),
            context.sample_time,
        )
        command, integral = limit_with_integral(rest, integral_before, increment, limit)
        return casadi.Function(
            self.kind,
            [state, reference, measured, gains],
            [command, casadi.vertcat(value, rate, integral, casadi.SX(1.0))],
            ["c", "r", "y", "g"],
            ["u", "c_next"],
        )


def limit_with_integral(
    rest: casadi.SX, integral_before: casadi.SX, increment: casadi.SX, limit: casadi.SX
) -> tuple[casadi.SX, casadi.SX]:
    """Add the integral part, limit the sum, and stop integration that would drive it further into the limit.

    This is conditional integration. Back-calculation is not used because the feedforward torque is added before the
    limit. Whenever the feedforward alone reaches the limit, back-calculation would load the integral part with a torque
    that the feedback never requested, and release it later on the path.

    Args:
        rest: Command without its integral part [Nm], (M, 1).
        integral_before: Integral part at the previous sample [Nm], (M, 1).
        increment: Increment of the integral part at this sample [Nm], (M, 1).
        limit: Largest absolute command [Nm], infinite for none, (M, 1).

    Returns:
        Command and integral part at this sample [Nm].
    """
    integrated = integral_before + increment
    wanted = rest + integrated
    winding_up = casadi.logic_and(casadi.fabs(wanted) > limit, increment * wanted > 0.0)
    integral = casadi.if_else(winding_up, integral_before, integrated)
    return casadi.fmax(-limit, casadi.fmin(limit, rest + integral)), integral
