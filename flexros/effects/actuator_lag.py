"""Time that the current loop of a motor takes."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

import casadi as ca
from pydantic import Field

from flexros.effects.command_law import AbstractCommandLaw
from flexros.effects.ranges import Range

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.effects.base import Stage
    from flexros.robot.kinematics import Value

_SHORT, _MANY = 1e-12, 0.02


class ActuatorLag(AbstractCommandLaw):
    """A lag of first order between commanded torque u and torque of the motor y: T dy/dt = u - y.

    The command is constant through an integration step, so that y is known exactly: u + (y0 - u) exp(-t/T). The motor
    gets the mean of y over the step, and is right to order two in the step; a time constant far below it costs nothing.
    The own states are y at the end of the step and its mean.
    """

    name: ClassVar[str] = "actuator_lag"
    stage: ClassVar[Stage] = "actuator"
    size: ClassVar[str] = "time_constant"
    rank: ClassVar[int] = 2
    stepwise_states = 2
    fingerprint: ClassVar[str] = (
        "prediction errors follow changes of the torque as with a delay, but the response also rolls off at high "
        "frequencies"
    )
    ranges: ClassVar[Mapping[str, Range]] = MappingProxyType(
        {"time_constant": Range("time", 1e-6, 0.02, starts=6, source="current loops of 0.05 to 2 kHz")}
    )

    time_constant: float = Field(0.0, ge=0.0, le=1.0, description="time constant T [s]")

    def passed(self, torque: ca.SX, own: ca.SX, values: Mapping[str, Value]) -> ca.SX:
        """Return the mean of the torque over the step."""
        del torque, values
        return own[1]

    def before_step(self, torque: ca.SX, own: ca.SX, values: Mapping[str, Value], step: ca.SX) -> ca.SX:
        """Move the torque on and take its mean over the step."""
        steps = step / ca.fmax(values["time_constant"], _SHORT)
        decay = ca.exp(-steps)
        series = 1 - steps / 2 * (1 - steps / 3 * (1 - steps / 4 * (1 - steps / 5)))
        share = ca.if_else(steps > _MANY, (1 - decay) / ca.fmax(steps, _MANY), series)
        before = own[0] - torque
        return ca.vertcat(torque + before * decay, torque + before * share)

    def rest(self, torque: ca.SX, values: Mapping[str, Value]) -> ca.SX:
        """Return what a constant torque leads to: itself."""
        del values
        return ca.vertcat(torque, torque)
