"""Counterbalance of an arm: a spring or a gas cylinder that carries weight."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

import casadi as ca
import numpy as np
from pydantic import Field

from flexros.effects.kinds.motor_law import AbstractMotorTorque, MotorState
from flexros.effects.kinds.ranges import Range

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.effects.kinds.base import Stage
    from flexros.robot import Robot
    from flexros.robot.symbolic.kinematics import Value


class Counterbalance(AbstractMotorTorque):
    """A torque that follows the position of the joint: c cos(q) + s sin(q), with the position q.

    A spring between a point of the frame and one of the arm, stretched from length zero, has this torque exactly; that
    of a gas cylinder is much like it. Heavy arms have one at the second joint. A diagnosis begins with one where it
    lowers what is left of the measured torque of its motor by far, or takes numbers of the model back within their
    tolerance; in a small motion it looks like a constant torque. Logs of servos have no torques: there it is a
    candidate like others, where several joints carry weight.
    """

    name: ClassVar[str] = "counterbalance"
    stage: ClassVar[Stage] = "actuator"
    sought_where: ClassVar[str] = (
        "in logs with torques, in those of servos of which several carry weight, or in place of a torque_curve"
    )
    size: ClassVar[str] = "cosine"
    further_sizes: ClassVar[tuple[str, ...]] = ("sine",)
    turned: ClassVar[tuple[str, ...]] = ("cosine",)
    plain: ClassVar[bool] = True
    signatures: ClassVar[tuple[str, ...]] = ("torque_over_position",)
    fingerprint: ClassVar[str] = (
        "a disturbance torque at one motor that follows the sine of its position, whatever the other joints do"
    )
    ranges: ClassVar[Mapping[str, Range]] = MappingProxyType(
        {
            "cosine": Range("torque", 1e-3, 5.0, starts=(0.1,), signed=True),
            "sine": Range("torque", 1e-3, 5.0, starts=(0.1,), signed=True),
        }
    )

    cosine: float = Field(0.0, description="additional torque at position 0 [Nm]")
    sine: float = Field(0.0, description="additional torque at position 90 degrees [Nm]")

    def locations(self, robot: Robot) -> tuple[str, ...]:
        """Return the motors that turn, on robots under gravity."""
        if not any(robot.spec.gravity.value):
            return ()
        return tuple(motor.name for motor in robot.motors if motor.rotary)

    def sought(self, robot: Robot, location: str) -> bool:
        """Return whether it is at one of several servos that carry weight at position zero.

        Other logs have torques, which show it, see `flexros.gap.search.torque_start`. What it does to the only servo
        that carries weight, another weight does as well.
        """
        gravity = np.abs(robot.spec.gravity.value)
        across = [motor for motor in robot.motors if gravity[motor.joint.axis] < np.linalg.norm(gravity)]
        carry = [motor.name for motor in across if motor.rotary]
        return robot.commands == "position" and len(carry) > 1 and location in carry

    def sought_for_curve(self, robot: Robot, location: str) -> bool:
        """Return True: one that carries little beside the weight of the arm is first seen as a curve."""
        del robot, location
        return True

    def added(self, motor: MotorState, values: Mapping[str, Value]) -> ca.SX:
        """Evaluate the torque at the position."""
        return values["cosine"] * ca.cos(motor.position) + values["sine"] * ca.sin(motor.position)
