"""Dry friction of constant level."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

import casadi as ca
from pydantic import Field

from flexros.effects.kinds.dry_friction import AbstractDryFriction, FrictionLevels
from flexros.effects.kinds.ranges import Range

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.effects.kinds.base import Stage
    from flexros.effects.kinds.motor_law import MotorState
    from flexros.robot.symbolic.kinematics import Value


class CoulombFriction(AbstractDryFriction):
    """Coulomb friction at a motor, with true sticking.

    With level F and asymmetry a the torque on a moving motor is -F (1 + a/2) forward and +F (1 - a/2) backward. At
    standstill it balances all other torques between these bounds. A diagnosis finds an asymmetry as a torque bias in
    addition to the friction, which is equivalent except at standstill.
    """

    name: ClassVar[str] = "coulomb_friction"
    stage: ClassVar[Stage] = "motor friction"
    size: ClassVar[str] = "level"
    signatures: ClassVar[tuple[str, ...]] = ("torque_over_speed", "torque_after_reversal")
    fingerprint: ClassVar[str] = (
        "a disturbance torque of constant magnitude against the motion, which changes sign at each reversal, and "
        "sticking of the motor at standstill"
    )
    ranges: ClassVar[Mapping[str, Range]] = MappingProxyType({"level": Range("torque", 1e-6, 1.0, starts=8)})

    level: float = Field(0.0, ge=0.0, description="mean of both directions [Nm or N]")
    asymmetry: float = Field(0.0, ge=-2.0, le=2.0, description="(forward - backward) / mean [1]")

    def levels(self, motor: MotorState, values: Mapping[str, Value]) -> FrictionLevels:
        """Return the two levels, independent of the speed."""
        del motor
        return FrictionLevels(
            ca.SX(values["level"] * (1 + values["asymmetry"] / 2)),
            ca.SX(values["level"] * (1 - values["asymmetry"] / 2)),
        )
