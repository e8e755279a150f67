"""Friction that is larger at standstill and low speed: the hump alone."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

import casadi as ca
from pydantic import Field

from flexros.effects.dry_friction import AbstractDryFriction, FrictionLevels
from flexros.effects.ranges import Range

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.effects.base import Stage
    from flexros.effects.motor_law import MotorState
    from flexros.robot.kinematics import Value

SLOWEST = 1e-12
"""Smallest Stribeck velocity that is not taken for zero [rad/s or m/s]."""


def hump(speed: ca.SX, extra: Value, velocity: Value) -> ca.SX:
    """Evaluate the extra friction at low speed, extra exp(-(v / velocity)^2) (Moberg 2007, eq. 3.15)."""
    return extra * ca.exp(-((speed / ca.fmax(velocity, SLOWEST)) ** 2))


class StribeckFriction(AbstractDryFriction):
    """Stribeck friction at a motor beyond that of high speed, with true sticking (Moberg 2007, eq. 3.15, static part).

    With extra level F and Stribeck velocity w the torque on a motor of speed v is F exp(-(v/w)^2) against the motion;
    at standstill it balances all other torques up to F. Coulomb friction is an effect of its own, their levels add.
    """

    name: ClassVar[str] = "stribeck_friction"
    stage: ClassVar[Stage] = "motor friction"
    size: ClassVar[str] = "extra"
    fingerprint: ClassVar[str] = (
        "friction torque against the motion at low speed only, most of it at standstill: stick and slip in slow motion"
    )
    ranges: ClassVar[Mapping[str, Range]] = MappingProxyType(
        {"extra": Range("torque", 1e-6, 1.0, starts=5), "velocity": Range("speed", 1e-4, 0.3, starts=5)}
    )

    extra: float = Field(0.0, ge=0.0, description="level at standstill beyond that of high speed [Nm or N]")
    velocity: float = Field(0.0, ge=0.0, description="Stribeck velocity of the motor [rad/s or m/s]")

    def levels(self, motor: MotorState, values: Mapping[str, Value]) -> FrictionLevels:
        """Evaluate the hump at the speed."""
        level = hump(motor.speed, values["extra"], values["velocity"])
        return FrictionLevels(level, level)
