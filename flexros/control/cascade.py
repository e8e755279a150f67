"""Cascade of a position and a speed controller, one per motor."""

from __future__ import annotations

from typing import ClassVar

import casadi
from pydantic import Field

from flexros.control.motorwise import AbstractMotorwiseLaw, Gain


class Cascade(AbstractMotorwiseLaw):
    """Proportional position controller around a PI speed controller, as in industrial drives.

    The speed is estimated from the motor position by differences and a low-pass filter (for robot controllers see
    Grotjahn and Heimann (2002), cited in Moberg (2007), section 5.5). For each motor:

        v_k = (tau v_{k-1} + y_k - y_{k-1}) / (tau + T)              filtered speed, backward Euler
        s_k = reference speed_k + kp (reference_k - y_k) - v_k       error of the speed loop
        I_k = I_{k-1} + T ki s_k                                     held at the limit, see `limit_with_integral`
        u_k = limit(feedforward_k + kv s_k + I_k)

    At the first sample the speed is zero. The state is [y_{k-1} (M), v (M), I (M), started].
    """

    kind: ClassVar[str] = "cascade"
    gain_keys: ClassVar[tuple[str, ...]] = ("position_gain", "speed_gain", "integral_gain", "speed_filter")

    position_gain: Gain = Field(description="gain kp of the position loop [1/s], one or one per motor")
    speed_gain: Gain = Field(description="proportional gain kv of the speed loop [Nms/rad], one or one per motor")
    integral_gain: Gain = Field(
        default=0.0, description="integral gain ki of the speed loop [Nm/rad], one or one per motor"
    )
    speed_filter: Gain = Field(
        default=0.0, description="time constant of the speed filter [s], 0 for none, one or one per motor"
    )

    def update(
        self,
        reference: tuple[casadi.SX, casadi.SX, casadi.SX],
        position: casadi.SX,
        gains: tuple[casadi.SX, ...],
        before: tuple[casadi.SX, casadi.SX, casadi.SX],
        sample_time: float,
    ) -> tuple[casadi.SX, casadi.SX, casadi.SX, casadi.SX]:
        """Compute one sample of all motors; see `AbstractMotorwiseLaw.update`."""
        target, target_speed, feedforward = reference
        position_gain, speed_gain, integral_gain, filter_time = gains
        position_before, speed_before, started = before
        previous = casadi.if_else(started, position_before, position)
        speed = (filter_time * speed_before + (position - previous)) / (filter_time + sample_time)
        error = target_speed + position_gain * (target - position) - speed
        rest = feedforward + speed_gain * error
        return rest, sample_time * integral_gain * error, position, speed
