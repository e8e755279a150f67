"""Torque of unknown law: a curve over the time."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

import casadi as ca
from pydantic import Field

from flexros.effects.kinds.curve import AbstractCurve, Extent, piecewise_linear, share_of_range, torques
from flexros.effects.kinds.motor_law import AbstractMotorTorque

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.effects.kinds.base import Stage
    from flexros.effects.kinds.motor_law import MotorState
    from flexros.effects.kinds.ranges import Range
    from flexros.robot.symbolic.kinematics import Value

_KNOTS = tuple(number / 5 for number in range(6))


class TorqueDrift(AbstractCurve, AbstractMotorTorque):
    """Torque at a motor that changes during operation, by no law of the other effects.

    Cables and hoses that become warm, a load that changes, a torque or current sensor that drifts. The torque is
    piecewise linear between six knots, evenly spread from `begin` to `end`, and constant before and after: a log that
    goes on keeps the last value. The own state is the time since the start of the run. A curve that was fitted to one
    log says nothing of another start: there it repeats only if what causes it does.
    """

    name: ClassVar[str] = "torque_drift"
    stage: ClassVar[Stage] = "actuator"
    size: ClassVar[str] = "torque_1"
    turned: ClassVar[tuple[str, ...]] = tuple(f"torque_{number}" for number in range(1, 7))
    words: ClassVar[str] = "torque over time of unknown law"
    smooth_states = 1
    intervals: ClassVar[int] = 5
    signatures: ClassVar[tuple[str, ...]] = ("torque_over_time", "torque_over_position")
    fingerprint: ClassVar[str] = (
        "equal motions late in the log have another disturbance torque than early ones, the same in both directions"
    )
    extends: ClassVar[Mapping[str, Mapping[str, str]]] = MappingProxyType(
        {"torque_bias": MappingProxyType({"torque_1": "level"})}
    )
    extent: ClassVar[Mapping[str, Extent]] = MappingProxyType({"begin": "first time", "end": "last time"})
    ranges: ClassVar[Mapping[str, Range]] = torques(f"torque_{number}" for number in range(1, 7))

    torque_1: float = Field(0.0, description="additional torque until the first knot [Nm or N]")
    torque_2: float = Field(0.0, description="the same at the second knot [Nm or N]")
    torque_3: float = Field(0.0, description="the same at the third knot [Nm or N]")
    torque_4: float = Field(0.0, description="the same at the fourth knot [Nm or N]")
    torque_5: float = Field(0.0, description="the same at the fifth knot [Nm or N]")
    torque_6: float = Field(0.0, description="the same from the last knot on [Nm or N]")
    begin: float = Field(0.0, description="time of the first knot since the start of the run [s]")
    end: float = Field(10.0, description="time of the last knot since the start of the run [s]")

    def states_of_time(self, time: float) -> tuple[float, ...]:
        """Return the time itself."""
        return (time,)

    def rates(self, motor: MotorState, values: Mapping[str, Value]) -> ca.SX:
        """Return the rate of the time, 1."""
        del motor, values
        return ca.SX(1)

    def added(self, motor: MotorState, values: Mapping[str, Value]) -> ca.SX:
        """Interpolate at the time."""
        relative = share_of_range(motor.own[0], values["begin"], values["end"])
        return piecewise_linear(relative, _KNOTS, [values[name] for name in self.ranges])
