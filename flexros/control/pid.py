"""Parallel discrete PID controller, one per motor."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, ClassVar, TypeAlias

import casadi
import numpy as np
from pydantic import Field

from flexros.control.base import AbstractControlLaw
from flexros.errors import InputError

if TYPE_CHECKING:
    from flexros.arrays import FloatArray

NotNegative: TypeAlias = Annotated[float, Field(ge=0.0)]
Positive: TypeAlias = Annotated[float, Field(gt=0.0)]


class Pid(AbstractControlLaw):
    """Parallel (non-interacting) PID on the motor position, with feedforward torque and torque limit.

    For each motor, with e_k = reference - measurement, sample time T and derivative filter time tau:

        s_k = (tau s_{k-1} + e_k - e_{k-1}) / (tau + T)             filtered rate of the error, backward Euler
        I_k = I_{k-1} + T ki e_k
        u_k = limit(feedforward_k + kp e_k + I_k + kd s_k)

    With tau = 0 and ki = 0 this is exactly the PD of the circle test of Moberg (2007), Paper B:
    u = feedforward + kp e_k + kd (e_k - e_{k-1}) / T. At the first sample the previous error is the present one, so
    that a start away from the reference gives no derivative kick.

    Anti-windup is conditional integration: I_k keeps its value while the command is at its limit and the error would
    drive it further out. Back-calculation was not taken, because the feedforward torque is added before the limit:
    whenever the feedforward alone reaches the limit, back-calculation would charge the integral with a torque that
    the feedback never asked for, and release it on the path afterwards.

    The state is [e_{k-1} (M), s (M), I (M), started], where s is kept without kd: gains may change while
    running without a step from stored derivative or integral torque.
    """

    kind: ClassVar[str] = "pid"

    kp: NotNegative | tuple[NotNegative, ...] = Field(description="proportional gain [Nm/rad], one or one per motor")
    ki: NotNegative | tuple[NotNegative, ...] = Field(
        default=0.0, description="integral gain [Nm/(rad s)], one or one per motor"
    )
    kd: NotNegative | tuple[NotNegative, ...] = Field(
        default=0.0, description="derivative gain [Nms/rad], one or one per motor"
    )
    derivative_filter: NotNegative | tuple[NotNegative, ...] = Field(
        default=0.0, description="time constant of the derivative filter [s], 0 for none, one or one per motor"
    )
    torque_limit: Positive | tuple[Positive, ...] | None = Field(
        default=None, description="limit of the command [Nm], one or one per motor; the robot's own where left out"
    )

    def state_size(self, n_motors: int) -> int:
        """Give the number of memory variables, 3 M + 1."""
        return 3 * n_motors + 1

    def gain_names(self, n_motors: int) -> tuple[str, ...]:
        """Name the gains: kp, ki, kd, derivative_filter, torque_limit, each for all motors."""
        kinds = ("kp", "ki", "kd", "derivative_filter", "torque_limit")
        return tuple(f"motor_{motor}.{kind}" for kind in kinds for motor in range(1, n_motors + 1))

    def gains(self, n_motors: int, torque_limits: FloatArray | None = None) -> FloatArray:
        """Give the gain vector; the torque limit is the lower one of the setting and the robot's."""
        limits = np.full(n_motors, np.inf) if torque_limits is None else np.asarray(torque_limits, dtype=float)
        if self.torque_limit is not None:
            limits = np.minimum(limits, per_motor("torque_limit", self.torque_limit, n_motors))
        settings = {"kp": self.kp, "ki": self.ki, "kd": self.kd, "derivative_filter": self.derivative_filter}
        return np.concatenate([*(per_motor(name, value, n_motors) for name, value in settings.items()), limits])

    def function(self, n_motors: int, sample_time: float) -> casadi.Function:
        """Build the update `(c, r, y, g) -> (u, c_next)` as a CasADi SX function."""
        state = casadi.SX.sym("c", self.state_size(n_motors))
        reference = casadi.SX.sym("r", 3 * n_motors)
        position = casadi.SX.sym("y", n_motors)
        gains = casadi.SX.sym("g", 5 * n_motors)
        error_before, rate_before, integral_before = casadi.vertsplit(state[:-1], n_motors)
        target, _, feedforward = casadi.vertsplit(reference, n_motors)
        kp, ki, kd, filter_time, limit = casadi.vertsplit(gains, n_motors)

        error = target - position
        previous = casadi.if_else(state[-1] > 0.5, error_before, error)
        rate = (filter_time * rate_before + (error - previous)) / (filter_time + sample_time)
        integrated = integral_before + sample_time * ki * error
        without_integral = feedforward + kp * error
        wanted = without_integral + integrated + kd * rate
        winding_up = casadi.logic_and(casadi.fabs(wanted) > limit, error * wanted > 0.0)
        integral = casadi.if_else(winding_up, integral_before, integrated)
        unlimited = without_integral + integral + kd * rate
        command = casadi.fmax(-limit, casadi.fmin(limit, unlimited))
        return casadi.Function(
            "pid",
            [state, reference, position, gains],
            [command, casadi.vertcat(error, rate, integral, casadi.SX(1.0))],
            ["state", "reference", "position", "gains"],
            ["command", "state_next"],
        )

    def bumpless_state(
        self,
        gains: FloatArray,
        sample_time: float,
        position: FloatArray,
        reference: FloatArray,
        torque: FloatArray,
    ) -> FloatArray:
        """Let the integral carry `torque`; a motor without integral gain starts from its proportional torque."""
        n_motors = len(position)
        kp, ki = gains[:n_motors], gains[n_motors : 2 * n_motors]
        error = reference[:n_motors] - position
        carried = torque - reference[2 * n_motors :] - kp * error - sample_time * ki * error
        integral = np.where(ki > 0.0, carried, 0.0)
        return np.concatenate([error, np.zeros(n_motors), integral, [1.0]])


def per_motor(name: str, value: float | tuple[float, ...], n_motors: int) -> FloatArray:
    """Spread a setting over the motors.

    Args:
        name: Name of the setting, for the error.
        value: One number for all motors, or one for each.
        n_motors: Number of motors M.

    Returns:
        The setting of each motor, shape (M,).

    Raises:
        InputError: The number of values is neither one nor M.
    """
    values: FloatArray = np.atleast_1d(np.asarray(value, dtype=float))
    if values.size not in (1, n_motors):
        raise InputError(
            f"controller.{name} has {values.size} values, allowed is one, or one for each of the {n_motors} motors"
        )
    return values * np.ones(n_motors)
