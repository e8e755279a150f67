"""Additional friction at standstill and low speed: the Stribeck hump alone."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

from pydantic import Field

from flexros.effects.friction.presliding_friction import PreslidingFriction
from flexros.effects.kinds.dry_friction import FrictionLevels
from flexros.effects.kinds.hump import GAUSSIAN, hump
from flexros.effects.kinds.ranges import Range
from flexros.effects.kinds.yielding_friction import (
    BRISTLES,
    AbstractYieldingFriction,
    bristle_damping,
    bristle_stiffness,
)

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.effects.kinds.base import Stage
    from flexros.effects.kinds.law import AbstractLaw
    from flexros.effects.kinds.motor_law import MotorState
    from flexros.robot.symbolic.kinematics import Value


class StribeckFriction(AbstractYieldingFriction):
    """Stribeck friction at a motor beyond that of high speed, with true sticking (Moberg 2007, eq. 3.15, static part).

    With extra level F, Stribeck velocity w and exponent d the torque on a motor of speed v is F exp(-|v/w|^d) against
    the motion; at standstill it balances all other torques up to F. The thesis has d = 2; measured humps have 0.5 to 2
    and more (Armstrong-Helouvry 1991, Control of Machines with Friction). Coulomb friction is a separate effect; the
    levels add.

    With a `stiffness` the hump holds by bristles of its own, as `coulomb_friction` does: where it is most of the
    friction at standstill, those of the Coulomb level alone yield by little.
    """

    name: ClassVar[str] = "stribeck_friction"
    stage: ClassVar[Stage] = "motor friction"
    size: ClassVar[str] = "extra"
    depends_on_speed: ClassVar[bool] = True
    signatures: ClassVar[tuple[str, ...]] = ("torque_over_speed",)
    fingerprint: ClassVar[str] = (
        "friction torque against the motion at low speed only, largest at standstill: stick-slip in slow motion"
    )
    ranges: ClassVar[Mapping[str, Range]] = MappingProxyType(
        {
            "extra": Range("torque", 1e-6, 1.0, starts=(0.001, 0.004, 0.016, 0.06, 0.2)),
            "velocity": Range("speed", 1e-4, 0.3, starts=(0.001, 0.004, 0.015, 0.05, 0.15), vanishes="never"),
            "exponent": Range("relative", 0.5, 4.0, starts=1, source="0.5 to 2 and more (Armstrong-Helouvry 1991)"),
            **BRISTLES,
        }
    )

    extra: float = Field(0.0, ge=0.0, description="level at standstill beyond that of high speed [Nm or N]")
    velocity: float = Field(0.0, ge=0.0, description="Stribeck velocity of the motor [rad/s or m/s]")
    exponent: float = Field(GAUSSIAN, gt=0.0, le=8.0, description="shape of the hump [1]; 2 is Gaussian")
    stiffness: float = bristle_stiffness()
    damping: float = bristle_damping()

    @property
    def acting(self) -> AbstractLaw:
        """Bristles where they have a stiffness."""
        return PreslidingFriction(**self.model_dump()) if self.stiffness > 0 else self

    def levels(self, motor: MotorState, values: Mapping[str, Value]) -> FrictionLevels:
        """Evaluate the hump at the speed."""
        level = hump(motor.speed, values["extra"], values["velocity"], values["exponent"])
        return FrictionLevels(level, level)
