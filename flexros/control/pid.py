"""Parallel discrete PID controller, one per motor."""

from __future__ import annotations

from typing import ClassVar

import casadi
from pydantic import Field

from flexros.control.motorwise import AbstractMotorwiseLaw, Gain


class Pid(AbstractMotorwiseLaw):
    """Parallel (non-interacting) PID on the motor position, with feedforward torque and torque limit.

    For each motor, with e_k = reference - measurement, sample time T and derivative filter time tau:

        s_k = (tau s_{k-1} + e_k - e_{k-1}) / (tau + T)             filtered rate of the error, backward Euler
        I_k = I_{k-1} + T ki e_k                                    held at the limit, see `limit_with_integral`
        u_k = limit(feedforward_k + kp e_k + kd s_k + I_k)

    With tau = 0 and ki = 0 this is exactly the PD of the circle test of Moberg (2007), Paper B:
    u = feedforward + kp e_k + kd (e_k - e_{k-1}) / T. At the first sample the previous error is the present one, so
    that a start away from the reference gives no derivative kick. The reference velocity is not used.

    The state is [e_{k-1} (M), s (M), I (M), started], where s is kept without kd: gains may change while
    running without a step from stored derivative or integral torque.
    """

    kind: ClassVar[str] = "pid"
    gain_keys: ClassVar[tuple[str, ...]] = ("kp", "ki", "kd", "derivative_filter")

    kp: Gain = Field(description="proportional gain [Nm/rad], one or one per motor")
    ki: Gain = Field(default=0.0, description="integral gain [Nm/(rad s)], one or one per motor")
    kd: Gain = Field(default=0.0, description="derivative gain [Nms/rad], one or one per motor")
    derivative_filter: Gain = Field(
        default=0.0, description="time constant of the derivative filter [s], 0 for none, one or one per motor"
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
        target, _, feedforward = reference
        kp, ki, kd, filter_time = gains
        error_before, rate_before, started = before
        error = target - position
        previous = casadi.if_else(started, error_before, error)
        rate = (filter_time * rate_before + (error - previous)) / (filter_time + sample_time)
        rest = feedforward + kp * error + kd * rate
        return rest, sample_time * ki * error, error, rate
