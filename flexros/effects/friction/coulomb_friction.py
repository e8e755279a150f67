"""Dry friction of constant level."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

import casadi as ca
from pydantic import Field, model_validator

from flexros.effects.friction.presliding_friction import PreslidingFriction
from flexros.effects.kinds.dry_friction import FrictionLevels
from flexros.effects.kinds.ranges import Range
from flexros.effects.kinds.yielding_friction import (
    BRISTLES,
    AbstractYieldingFriction,
    bristle_damping,
    bristle_stiffness,
)

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flexros.effects.kinds.base import AbstractEffect, Stage
    from flexros.effects.kinds.law import AbstractLaw
    from flexros.effects.kinds.motor_law import MotorState
    from flexros.robot import Robot
    from flexros.robot.symbolic.kinematics import Value


class CoulombFriction(AbstractYieldingFriction):
    """Coulomb friction at a motor, with true sticking.

    With level F and asymmetry a the torque on a moving motor is -F (1 + a/2) forward and +F (1 - a/2) backward. At
    standstill it balances all other torques between these bounds. A level below zero reduces the Coulomb friction that
    a nominal model has at that motor, such as the frictionloss of an MJCF, at most to zero. A diagnosis finds an
    asymmetry as a torque bias in addition to the friction, which is equivalent except at standstill.

    Contacts are not rigid: with a `stiffness` the motor is held by bristles, the law of `presliding_friction`, with
    their `damping`. Bristles that bend by less than the encoder shows still move the instants of reversals, and with
    them the sizes of everything else that is fitted.
    """

    name: ClassVar[str] = "coulomb_friction"
    stage: ClassVar[Stage] = "motor friction"
    size: ClassVar[str] = "level"
    turned: ClassVar[tuple[str, ...]] = ("asymmetry",)
    one_level: ClassVar[bool] = True
    reduces: ClassVar[bool] = True
    signatures: ClassVar[tuple[str, ...]] = ("torque_over_speed", "torque_after_reversal")
    fingerprint: ClassVar[str] = (
        "a disturbance torque of constant magnitude against the motion, which changes sign at each reversal, and "
        "sticking of the motor at standstill"
    )
    ranges: ClassVar[Mapping[str, Range]] = MappingProxyType(
        {"level": Range("torque", 1e-6, 1.0, starts=8), **BRISTLES}
    )

    level: float = Field(
        0.0, description="mean of both directions; below zero where that of another one there is too large [Nm or N]"
    )
    asymmetry: float = Field(0.0, ge=-2.0, le=2.0, description="(forward - backward) / mean [1]")
    stiffness: float = bristle_stiffness()
    damping: float = bristle_damping()

    @model_validator(mode="after")
    def _even(self) -> CoulombFriction:
        if self.stiffness > 0 and self.asymmetry != 0:
            raise ValueError(
                f"stiffness is {self.stiffness:g} and asymmetry {self.asymmetry:g}, but bristles hold evenly; give "
                "torque_bias beside it instead of asymmetry"
            )
        if self.stiffness > 0 and self.level < 0:
            raise ValueError(
                f"stiffness is {self.stiffness:g} and level {self.level:g}, but bristles hold with a level above zero; "
                "give no stiffness"
            )
        return self

    @property
    def acting(self) -> AbstractLaw:
        """Bristles where they have a stiffness."""
        if self.stiffness == 0:
            return self
        return PreslidingFriction(level=self.level, stiffness=self.stiffness, damping=self.damping)

    def reductions(self, robot: Robot, location: str, known: Sequence[AbstractEffect] = ()) -> Mapping[str, float]:
        """Return the Coulomb friction that the nominal model has, which is all that can be missing."""
        del robot, location
        return {"level": sum((one.level for one in known if isinstance(one, CoulombFriction)), start=0.0)}

    def levels(self, motor: MotorState, values: Mapping[str, Value]) -> FrictionLevels:
        """Return the two levels, independent of the speed."""
        del motor
        return FrictionLevels(
            ca.SX(values["level"] * (1 + values["asymmetry"] / 2)),
            ca.SX(values["level"] * (1 - values["asymmetry"] / 2)),
        )
