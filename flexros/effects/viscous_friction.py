"""Friction proportional to speed, different in the two directions."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import casadi as ca
from pydantic import Field

from flexros.effects.motor_law import AbstractMotorTorque, MotorState

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.effects.base import Stage
    from flexros.robot.kinematics import Value


class ViscousFriction(AbstractMotorTorque):
    """Viscous friction at a motor, beyond the nominal one.

    With coefficient f and asymmetry a the torque on the motor is -f (1 + a/2) v forward and -f (1 - a/2) v backward,
    which is -f (v + a/2 |v|): the mean of the directions is f, their difference a f.
    """

    name: ClassVar[str] = "viscous_friction"
    stage: ClassVar[Stage] = "motor friction"
    size: ClassVar[str] = "coefficient"

    coefficient: float = Field(0.0, ge=0.0, description="mean of both directions [Nm s/rad or N s/m]")
    asymmetry: float = Field(0.0, ge=-2.0, le=2.0, description="(forward - backward) / mean [1]")

    def added(self, motor: MotorState, values: Mapping[str, Value]) -> ca.SX:
        """Brake in proportion to the speed."""
        return -values["coefficient"] * (motor.speed + values["asymmetry"] / 2 * ca.fabs(motor.speed))
