"""Friction of unknown law: a curve over the speed."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

import casadi as ca
from pydantic import Field

from flexros.effects.kinds.curve import SMALLEST, AbstractCurve, Extent, piecewise_linear, torques
from flexros.effects.kinds.dry_friction import AbstractDryFriction, FrictionLevels
from flexros.effects.kinds.motor_law import AbstractMotorTorque

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.effects.kinds.base import Stage
    from flexros.effects.kinds.motor_law import MotorState
    from flexros.effects.kinds.ranges import Range
    from flexros.robot.symbolic.kinematics import Value

_EVEN = (0.0, 0.5, 1.0)
_ODD = (0.0, 0.1, 0.25, 0.5, 0.75, 1.0)


class FrictionCurve(AbstractCurve, AbstractMotorTorque, AbstractDryFriction):
    """Friction torque at a motor as a function of speed that follows no law of the other effects.

    With level F and the piecewise linear curves f (`speed_...`) and g (`uneven_...`), zero at standstill, the torque
    on a motor of speed v is sign(v) (F + f(|v| / w)) + g(|v| / w) against the motion, constant above the speed w. All
    sizes may be negative where other friction is larger; the sum of the levels of dry friction at a motor does not
    fall below zero. The numbers in the names are speeds in per cent of w.
    """

    name: ClassVar[str] = "friction_curve"
    stage: ClassVar[Stage] = "motor friction"
    size: ClassVar[str] = "standstill"
    turned: ClassVar[tuple[str, ...]] = ("uneven_50", "uneven_100")
    words: ClassVar[str] = "friction of unknown law"
    eases = True
    depends_on_speed: ClassVar[bool] = True
    uneven: ClassVar[tuple[str, ...]] = ("uneven_50", "uneven_100")
    signatures: ClassVar[tuple[str, ...]] = ("torque_over_speed",)
    fingerprint: ClassVar[str] = (
        "a disturbance torque against the motion that depends on the speed in another way than any law of friction "
        "says, the same throughout the log"
    )
    extends: ClassVar[Mapping[str, Mapping[str, str]]] = MappingProxyType(
        {
            "coulomb_friction": MappingProxyType({"standstill": "level"}),
            "viscous_friction": MappingProxyType({"speed_100": "coefficient", "uneven_100": "asymmetry"}),
        }
    )
    extent: ClassVar[Mapping[str, Extent]] = MappingProxyType({"speed": "largest speed"})
    ranges: ClassVar[Mapping[str, Range]] = torques(
        ("standstill", *(f"speed_{100 * x:.0f}" for x in _ODD[1:]), *(f"uneven_{100 * x:.0f}" for x in _EVEN[1:]))
    )

    standstill: float = Field(0.0, description="level at lowest speed, which also sticks [Nm or N]")
    speed_10: float = Field(0.0, description="friction beyond that level at 10 % of the speed [Nm or N]")
    speed_25: float = Field(0.0, description="the same at 25 % [Nm or N]")
    speed_50: float = Field(0.0, description="the same at 50 % [Nm or N]")
    speed_75: float = Field(0.0, description="the same at 75 % [Nm or N]")
    speed_100: float = Field(0.0, description="the same at the whole speed and above [Nm or N]")
    uneven_50: float = Field(0.0, description="half of forward less backward friction at 50 % [Nm or N]")
    uneven_100: float = Field(0.0, description="the same at the whole speed and above [Nm or N]")
    speed: float = Field(1.0, gt=0.0, description="speed of the last knot [rad/s or m/s]")

    def added(self, motor: MotorState, values: Mapping[str, Value]) -> ca.SX:
        """Return the torque of the two curves, which is zero at standstill."""
        relative = ca.fabs(motor.speed) / ca.fmax(values["speed"], SMALLEST)
        odd = piecewise_linear(relative, _ODD, [0.0, *(values[f"speed_{100 * x:.0f}"] for x in _ODD[1:])])
        even = piecewise_linear(relative, _EVEN, [0.0, *(values[f"uneven_{100 * x:.0f}"] for x in _EVEN[1:])])
        return -(ca.if_else(motor.speed < 0, -odd, odd) + even)

    def levels(self, motor: MotorState, values: Mapping[str, Value]) -> FrictionLevels:
        """Return the level at lowest speed."""
        del motor
        return FrictionLevels(ca.SX(values["standstill"]), ca.SX(values["standstill"]))
