"""Friction proportional to speed, different in the two directions."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

import casadi as ca
from pydantic import Field

from flexros.effects.kinds.motor_law import AbstractMotorTorque, MotorState
from flexros.effects.kinds.ranges import Range
from flexros.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flexros.effects.kinds.base import AbstractEffect, Stage
    from flexros.robot import Robot
    from flexros.robot.symbolic.kinematics import Value


class ViscousFriction(AbstractMotorTorque):
    """Viscous friction at a motor beyond the nominal one, and different friction in the two directions.

    With coefficient f in addition to the nominal f_0 and asymmetry a, the total friction torque on the motor is
    -(f_0 + f) (1 + a/2) v forward and -(f_0 + f) (1 - a/2) v backward: the mean of the directions is f_0 + f, and their
    difference a (f_0 + f). Nominal friction that differs in the two directions is an asymmetry without coefficient. A
    coefficient below zero, at most -f_0, says that the nominal friction is too large.
    """

    name: ClassVar[str] = "viscous_friction"
    stage: ClassVar[Stage] = "motor friction"
    size: ClassVar[str] = "coefficient"
    further_sizes: ClassVar[tuple[str, ...]] = ("asymmetry",)
    turned: ClassVar[tuple[str, ...]] = ("asymmetry",)
    uneven: ClassVar[tuple[str, ...]] = ("asymmetry",)
    signatures: ClassVar[tuple[str, ...]] = ("torque_over_speed", "frequency_response")
    fingerprint: ClassVar[str] = "a disturbance torque against the motion, proportional to the speed of the motor"
    ranges: ClassVar[Mapping[str, Range]] = MappingProxyType(
        {
            "coefficient": Range("torque/speed", 1e-6, 1.0, starts=5, widest=10.0),
            "asymmetry": Range("relative", 0.05, 2.0, starts=1, signed=True),
        }
    )

    coefficient: float = Field(
        0.0,
        description="beyond the nominal one, mean of both; below zero where that is too large [Nm s/rad or N s/m]",
    )
    asymmetry: float = Field(0.0, ge=-2.0, le=2.0, description="of the whole friction: (forward - backward) / mean [1]")

    def numbers(self, robot: Robot, location: str) -> tuple[str, ...]:
        """Return the nominal friction of the motor."""
        del robot
        return (f"{location}.viscous_friction",)

    def reductions(self, robot: Robot, location: str, known: Sequence[AbstractEffect] = ()) -> Mapping[str, float]:
        """Return the nominal friction, which is all that can be missing."""
        del known
        (nominal,) = self.numbers(robot, location)
        return {"coefficient": robot.parameters[nominal].value}

    def check_on(self, robot: Robot, location: str) -> None:
        """Refuse a coefficient that makes the friction of a motor negative."""
        nominal = self.reductions(robot, location)["coefficient"]
        if self.coefficient < -nominal:
            raise InputError(
                f"{self.name}@{location}: coefficient is {self.coefficient:g}, but {robot.name} has a viscous friction "
                f"of {nominal:g} there; give at least {-nominal:g}"
            )

    def added(self, motor: MotorState, values: Mapping[str, Value]) -> ca.SX:
        """Return the additional viscous friction."""
        total = motor.viscous_friction + values["coefficient"]
        return -(values["coefficient"] * motor.speed + total * values["asymmetry"] / 2 * ca.fabs(motor.speed))
