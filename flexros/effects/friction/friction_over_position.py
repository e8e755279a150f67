"""Friction of unknown law over the motor position: a curve of levels."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

from pydantic import Field

from flexros.effects.kinds.curve import AbstractCurve, Extent, mirrored, piecewise_linear, share_of_range, torques
from flexros.effects.kinds.dry_friction import AbstractDryFriction, FrictionLevels

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.effects.kinds.base import Stage
    from flexros.effects.kinds.motor_law import MotorState
    from flexros.effects.kinds.ranges import Range
    from flexros.robot.symbolic.kinematics import Value

_KNOTS = tuple(number / 7 for number in range(8))


class FrictionOverPosition(AbstractCurve, AbstractDryFriction):
    """Dry friction at a motor whose level is a function of the position, with sticking.

    Ball screws and linear guides that are worn or bent, seals, gears with a tight place. The level is piecewise linear
    between eight knots, evenly spread from the lowest to the highest position, and constant beyond these. Levels may
    be negative where other friction is larger; the sum of the levels of dry friction at a motor does not fall below
    zero.
    """

    name: ClassVar[str] = "friction_over_position"
    stage: ClassVar[Stage] = "motor friction"
    size: ClassVar[str] = "level_1"
    words: ClassVar[str] = "friction over position of unknown law"
    eases = True
    told_by_reversals: ClassVar[bool] = True
    signatures: ClassVar[tuple[str, ...]] = ("torque_over_position", "torque_over_speed")
    fingerprint: ClassVar[str] = (
        "a disturbance torque against the motion that changes sign at each reversal and depends on the motor position, "
        "the same at all speeds and throughout the log"
    )
    extends: ClassVar[Mapping[str, Mapping[str, str]]] = MappingProxyType(
        {"coulomb_friction": MappingProxyType({"level_1": "level"})}
    )
    extent: ClassVar[Mapping[str, Extent]] = MappingProxyType({"low": "lowest angle", "high": "highest angle"})
    ranges: ClassVar[Mapping[str, Range]] = torques(f"level_{number}" for number in range(1, 9))

    level_1: float = Field(0.0, description="level at the lowest position [Nm or N]")
    level_2: float = Field(0.0, description="the same at the second knot [Nm or N]")
    level_3: float = Field(0.0, description="the same at the third knot [Nm or N]")
    level_4: float = Field(0.0, description="the same at the fourth knot [Nm or N]")
    level_5: float = Field(0.0, description="the same at the fifth knot [Nm or N]")
    level_6: float = Field(0.0, description="the same at the sixth knot [Nm or N]")
    level_7: float = Field(0.0, description="the same at the seventh knot [Nm or N]")
    level_8: float = Field(0.0, description="the same at the highest position [Nm or N]")
    low: float = Field(-1.0, description="lowest position [rad or m]")
    high: float = Field(1.0, description="highest position [rad or m]")

    def turned_round(self) -> FrictionOverPosition:
        """Return it with its levels in the opposite order."""
        return mirrored(self, 1.0)

    def levels(self, motor: MotorState, values: Mapping[str, Value]) -> FrictionLevels:
        """Interpolate at the position, the same in both directions."""
        relative = share_of_range(motor.position, values["low"], values["high"])
        level = piecewise_linear(relative, _KNOTS, [values[name] for name in self.ranges])
        return FrictionLevels(level, level)
