"""Cascade of a position and a speed controller, one per motor."""

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

_GAINS = ("position_gain", "speed_gain", "integral_gain", "speed_filter")


class Cascade(AbstractControlLaw):
    """Proportional position controller around a PI speed controller, as in industrial drives.

    The speed is estimated from the motor position by differences and a low-pass filter (for robot controllers see
    Grotjahn and Heimann (2002), cited in Moberg (2007), section 5.4). For each motor:

        v_k = (tau v_{k-1} + y_k - y_{k-1}) / (tau + T)              filtered speed, backward Euler
        s_k = reference speed_k + kp (reference_k - y_k) - v_k       error of the speed loop
        I_k = I_{k-1} + T ki s_k                                     stopped at the limit, see `anti_windup`
        u_k = limit(feedforward_k + kv s_k + I_k)

    At the first sample the speed is zero. The state is [y_{k-1} (M), v (M), I (M), started].
    """

    kind: ClassVar[str] = "cascade"

    position_gain: Gain = Field(description="gain kp of the position loop [1/s], one or one per motor")
    speed_gain: Gain = Field(description="proportional gain kv of the speed loop [Nms/rad], one or one per motor")
    integral_gain: Gain = Field(
        default=0.0, description="integral gain ki of the speed loop [Nm/rad], one or one per motor"
    )
    speed_filter: Gain = Field(
        default=0.0, description="time constant of the speed filter [s], 0 for none, one or one per motor"
    )
    torque_limit: TorqueLimit = Field(
        default=None, description="limit of the command [Nm], one or one per motor; the robot's own where left out"
    )

    def state_size(self, n_motors: int) -> int:
        """Give the number of memory variables, 3 M + 1."""
        return 3 * n_motors + 1

    def gain_names(self, n_motors: int) -> tuple[str, ...]:
        """Name the gains: position_gain, speed_gain, integral_gain, speed_filter, torque_limit, each for all motors."""
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
        position_before, speed_before, integral_before = casadi.vertsplit(state[:-1], n_motors)
        target, target_speed, feedforward = casadi.vertsplit(reference, n_motors)
        position_gain, speed_gain, integral_gain, filter_time, limit = casadi.vertsplit(gains, n_motors)

        previous = casadi.if_else(state[-1] > 0.5, position_before, position)
        speed = (filter_time * speed_before + (position - previous)) / (filter_time + sample_time)
        error = target_speed + position_gain * (target - position) - speed
        rest = feedforward + speed_gain * error
        command, integral = limit_with_integral(rest, integral_before, sample_time * integral_gain * error, limit)
        return casadi.Function(
            self.kind,
            [state, reference, position, gains],
            [command, casadi.vertcat(position, speed, integral, casadi.SX(1.0))],
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
        """Let the integral carry `torque` from rest; a motor without integral gain starts from its proportional one."""
        n_motors = len(position)
        position_gain, speed_gain, integral_gain = gains[: 3 * n_motors].reshape(3, n_motors)
        error = reference[n_motors : 2 * n_motors] + position_gain * (reference[:n_motors] - position)
        carried = torque - reference[2 * n_motors :] - speed_gain * error - sample_time * integral_gain * error
        integral = np.where(integral_gain > 0.0, carried, 0.0)
        return np.concatenate([position, np.zeros(n_motors), integral, [1.0]])
