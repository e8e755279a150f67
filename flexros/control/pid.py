"""Parallel discrete PID controller, one per motor."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import casadi
import numpy as np
from pydantic import Field

from flexros.control.anti_windup import limit_with_integral
from flexros.control.base import AbstractControlLaw
from flexros.control.settings import Gain, TorqueLimit, gain_vector, gain_vector_names

if TYPE_CHECKING:
    from flexros.arrays import FloatArray

_GAINS = ("kp", "ki", "kd", "derivative_filter")


class Pid(AbstractControlLaw):
    """Parallel (non-interacting) PID on the motor position, with feedforward torque and torque limit.

    For each motor, with e_k = reference - measurement, sample time T and derivative filter time tau:

        s_k = (tau s_{k-1} + e_k - e_{k-1}) / (tau + T)             filtered rate of the error, backward Euler
        I_k = I_{k-1} + T ki e_k                                    stopped at the limit, see `anti_windup`
        u_k = limit(feedforward_k + kp e_k + kd s_k + I_k)

    With tau = 0 and ki = 0 this is exactly the PD of the circle test of Moberg (2007), Paper B:
    u = feedforward + kp e_k + kd (e_k - e_{k-1}) / T. At the first sample the previous error is the present one, so
    that a start away from the reference gives no derivative kick. The reference velocity is not used.

    The state is [e_{k-1} (M), s (M), I (M), started], where s is kept without kd: gains may change while
    running without a step from stored derivative or integral torque.
    """

    kind: ClassVar[str] = "pid"

    kp: Gain = Field(description="proportional gain [Nm/rad], one or one per motor")
    ki: Gain = Field(default=0.0, description="integral gain [Nm/(rad s)], one or one per motor")
    kd: Gain = Field(default=0.0, description="derivative gain [Nms/rad], one or one per motor")
    derivative_filter: Gain = Field(
        default=0.0, description="time constant of the derivative filter [s], 0 for none, one or one per motor"
    )
    torque_limit: TorqueLimit = Field(
        default=None, description="limit of the command [Nm], one or one per motor; the robot's own where left out"
    )

    def state_size(self, n_motors: int) -> int:
        """Give the number of memory variables, 3 M + 1."""
        return 3 * n_motors + 1

    def gain_names(self, n_motors: int) -> tuple[str, ...]:
        """Name the gains: kp, ki, kd, derivative_filter, torque_limit, each for all motors."""
        return gain_vector_names(_GAINS, n_motors)

    def gains(self, n_motors: int, torque_limits: FloatArray | None = None) -> FloatArray:
        """Give the gain vector; the torque limit is the lower one of the setting and the robot's."""
        gains = {name: getattr(self, name) for name in _GAINS}
        return gain_vector(gains, self.torque_limit, torque_limits, n_motors)

    def function(self, n_motors: int, sample_time: float) -> casadi.Function:
        """Build the update `(c, r, y, g) -> (u, c_next)` as a CasADi SX function."""
        state = casadi.SX.sym("c", self.state_size(n_motors))
        reference = casadi.SX.sym("r", 3 * n_motors)
        position = casadi.SX.sym("y", n_motors)
        gains = casadi.SX.sym("g", (len(_GAINS) + 1) * n_motors)
        error_before, rate_before, integral_before = casadi.vertsplit(state[:-1], n_motors)
        target, _, feedforward = casadi.vertsplit(reference, n_motors)
        kp, ki, kd, filter_time, limit = casadi.vertsplit(gains, n_motors)

        error = target - position
        previous = casadi.if_else(state[-1] > 0.5, error_before, error)
        rate = (filter_time * rate_before + (error - previous)) / (filter_time + sample_time)
        rest = feedforward + kp * error + kd * rate
        command, integral = limit_with_integral(rest, integral_before, sample_time * ki * error, limit)
        return casadi.Function(
            self.kind,
            [state, reference, position, gains],
            [command, casadi.vertcat(error, rate, integral, casadi.SX(1.0))],
            ["c", "r", "y", "g"],
            ["u", "c_next"],
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
