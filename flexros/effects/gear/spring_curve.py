"""Spring of unknown law: a curve over the deflection."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

import casadi as ca
from pydantic import Field

from flexros.effects.kinds.curve import SMALLEST, AbstractCurve, Extent, piecewise_linear, torques
from flexros.effects.kinds.gear_law import AbstractGearLaw

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.effects.kinds.base import Stage
    from flexros.effects.kinds.gear_law import GearState, GearTorques
    from flexros.effects.kinds.ranges import Range
    from flexros.robot import Robot
    from flexros.robot.symbolic.kinematics import Value

_PARTS = (25, 50, 75, 100)
_KNOTS = (0.0, *(part / 100 for part in _PARTS))
_SIDES = tuple(tuple(f"{side}_{part}" for part in _PARTS) for side in ("positive", "negative"))
TURNED = 0.1
"""Largest deflection to one side over that to the other from which a log shows the curve there [1] (chosen)."""


class SpringCurve(AbstractCurve, AbstractGearLaw):
    """Torque of a spring as a function of its deflection that follows no law, in addition to the nominal spring.

    The additional torque is piecewise linear in the deflection, with four knots to each side, at 25, 50, 75 and 100 per
    cent of the lowest and the highest deflection; it is zero without deflection, and constant beyond the last knots.
    The effect acts between motor and arm for a gear, on the arm coordinate for the other springs; the damper is
    unchanged. A harder spring has a positive torque at positive deflections and a negative one at negative ones.
    """

    name: ClassVar[str] = "spring_curve"
    stage: ClassVar[Stage] = "gear"
    size: ClassVar[str] = "positive_100"
    words: ClassVar[str] = "stiffness of unknown law"
    rank: ClassVar[int] = 1
    signatures: ClassVar[tuple[str, ...]] = ("torsion_over_torque", "frequency_response", "detection_lines")
    fingerprint: ClassVar[str] = (
        "the torque of the spring depends on its deflection in another way than any law says, also differently to both "
        "sides, without loss of energy; resonance and antiresonance shift with amplitude and static load"
    )
    extends: ClassVar[Mapping[str, Mapping[str, str]]] = MappingProxyType(
        {"stiffness_error": MappingProxyType({"positive_100": "relative", "negative_100": "relative"})}
    )
    extent: ClassVar[Mapping[str, Extent]] = MappingProxyType(
        {"low": "lowest deflection", "high": "highest deflection"}
    )
    ranges: ClassVar[Mapping[str, Range]] = torques(
        (name for side in _SIDES for name in side), "chosen; of the nominal spring"
    )

    positive_25: float = Field(0.0, description="additional torque at 25 % of the highest deflection [Nm or N]")
    positive_50: float = Field(0.0, description="the same at 50 % [Nm or N]")
    positive_75: float = Field(0.0, description="the same at 75 % [Nm or N]")
    positive_100: float = Field(0.0, description="the same at the highest deflection and above [Nm or N]")
    negative_25: float = Field(0.0, description="additional torque at 25 % of the lowest deflection [Nm or N]")
    negative_50: float = Field(0.0, description="the same at 50 % [Nm or N]")
    negative_75: float = Field(0.0, description="the same at 75 % [Nm or N]")
    negative_100: float = Field(0.0, description="the same at the lowest deflection and below [Nm or N]")
    low: float = Field(-1.0, le=0.0, description="lowest deflection, not above 0 [rad or m]")
    high: float = Field(1.0, ge=0.0, description="highest deflection, not below 0 [rad or m]")

    @property
    def shown(self) -> tuple[str, ...]:
        """Sizes of the sides to which the spring is turned."""
        most = self.high, -self.low
        return tuple(name for end, side in zip(most, _SIDES, strict=True) if end > TURNED * max(most) for name in side)

    def turned_round(self) -> SpringCurve:
        """Return it with opposite torques on the other side."""
        pairs = zip((name for side in _SIDES for name in side), (name for side in reversed(_SIDES) for name in side))
        torques = {name: -getattr(self, other) for name, other in pairs}
        return self.model_copy(update={**torques, "low": -self.high, "high": -self.low})

    def locations(self, robot: Robot) -> tuple[str, ...]:
        """Return the springs."""
        return tuple(name for name in robot.arm_names if f"{name}.stiffness" in robot.parameters)

    def added(self, gear: GearState, values: Mapping[str, Value]) -> GearTorques:
        """Return the additional torque of the spring."""
        return gear.transmits(_more(gear.deflection, values))

    def onward(self, gear: GearState, values: Mapping[str, Value]) -> GearState:
        """Pass the changed spring."""
        return replace(
            gear,
            torque=gear.torque + _more(gear.deflection, values),
            spring=lambda deflection: gear.spring(deflection) + _more(deflection, values),
        )


def _more(deflection: ca.SX, values: Mapping[str, Value]) -> ca.SX:
    """Return the torque in addition to that of the nominal spring."""
    more = ca.SX(0)
    for relative, side in zip((deflection / _size(values["high"]), deflection / -_size(-values["low"])), _SIDES):
        more += piecewise_linear(relative, _KNOTS, [0.0, *(values[name] for name in side)])
    return more


def _size(end: Value) -> ca.SX:
    return ca.fmax(end, SMALLEST)
