"""Torque of unknown law: a curve over the motor position."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

from pydantic import Field

from flexros.effects.kinds.curve import AbstractCurve, Extent, mirrored, piecewise_linear, share_of_range, torques
from flexros.effects.kinds.motor_law import AbstractMotorTorque

if TYPE_CHECKING:
    from collections.abc import Mapping

    import casadi as ca

    from flexros.effects.kinds.base import Stage
    from flexros.effects.kinds.motor_law import MotorState
    from flexros.effects.kinds.ranges import Range
    from flexros.robot.symbolic.kinematics import Value

_KNOTS = tuple(number / 7 for number in range(-1, 9))


class TorqueCurve(AbstractCurve, AbstractMotorTorque):
    """Torque at a motor as a function of its position that follows no law of the other effects.

    Cables and hoses, balancing springs, gravity of what the model lacks. The torque is piecewise linear between eight
    knots, evenly spread from the lowest to the highest position. Beyond these it goes on as steeply for the length of
    one more interval, and is constant from there.
    """

    name: ClassVar[str] = "torque_curve"
    stage: ClassVar[Stage] = "actuator"
    size: ClassVar[str] = "torque_1"
    words: ClassVar[str] = "torque over position of unknown law"
    signatures: ClassVar[tuple[str, ...]] = ("torque_over_position",)
    fingerprint: ClassVar[str] = (
        "a disturbance torque that depends on the motor position in another way than any law says, the same in both "
        "directions and at all speeds"
    )
    extends: ClassVar[Mapping[str, Mapping[str, str]]] = MappingProxyType(
        {"torque_bias": MappingProxyType({"torque_1": "level"})}
    )
    extent: ClassVar[Mapping[str, Extent]] = MappingProxyType({"low": "lowest angle", "high": "highest angle"})
    ranges: ClassVar[Mapping[str, Range]] = torques(f"torque_{number}" for number in range(1, 9))

    torque_1: float = Field(0.0, description="additional torque at the lowest position [Nm or N]")
    torque_2: float = Field(0.0, description="the same at the second knot [Nm or N]")
    torque_3: float = Field(0.0, description="the same at the third knot [Nm or N]")
    torque_4: float = Field(0.0, description="the same at the fourth knot [Nm or N]")
    torque_5: float = Field(0.0, description="the same at the fifth knot [Nm or N]")
    torque_6: float = Field(0.0, description="the same at the sixth knot [Nm or N]")
    torque_7: float = Field(0.0, description="the same at the seventh knot [Nm or N]")
    torque_8: float = Field(0.0, description="the same at the highest position [Nm or N]")
    low: float = Field(-1.0, description="lowest position [rad or m]")
    high: float = Field(1.0, description="highest position [rad or m]")

    def turned_round(self) -> TorqueCurve:
        """Return it with opposite torques in the opposite order."""
        return mirrored(self, -1.0)

    def added(self, motor: MotorState, values: Mapping[str, Value]) -> ca.SX:
        """Interpolate at the position."""
        relative = share_of_range(motor.position, values["low"], values["high"])
        torques = [values[name] for name in self.ranges]
        before, after = 2 * torques[0] - torques[1], 2 * torques[-1] - torques[-2]
        return piecewise_linear(relative, _KNOTS, [before, *torques, after])
