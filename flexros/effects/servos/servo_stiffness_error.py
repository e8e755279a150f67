"""Error of the stiffness of a servo."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from flexros.effects.kinds.relative_error import AbstractRelativeError
from flexros.effects.kinds.servo_number import gains_are_sought, servo_motors
from flexros.robot.parameters import SERVO

if TYPE_CHECKING:
    from flexros.effects.kinds.base import Stage
    from flexros.robot import Robot


class ServoStiffnessError(AbstractRelativeError):
    """The proportional gain of a position loop scaled.

    It is sought in logs with position commands only. Where the servo has no damping, or that does not show, an error of
    the torque constant is the same; else that is a torque gain error. Positions determine gain, inertia and friction up
    to a common factor, which gravity alone fixes.
    """

    name: ClassVar[str] = "servo_stiffness_error"
    stage: ClassVar[Stage] = "actuator"
    sought_where: ClassVar[str] = "in logs with position commands, at servos whose gains are not stated as known"
    common_factor: ClassVar[str] = "relative"
    signatures: ClassVar[tuple[str, ...]] = ("effective_torque", "torque_over_position")
    fingerprint: ClassVar[str] = (
        "the motor follows its commanded position more or less stiffly: the errors are proportional to the distance "
        "between command and position, also at standstill under load"
    )

    def locations(self, robot: Robot) -> tuple[str, ...]:
        """Return the motors with a servo."""
        return servo_motors(robot)

    def sought(self, robot: Robot, location: str) -> bool:
        """Return whether the robot is commanded by positions and the gains are not known."""
        return gains_are_sought(robot, location)

    def numbers(self, robot: Robot, location: str) -> tuple[str, ...]:
        """Return the stiffness of the servo."""
        del robot
        return (f"{location}.{SERVO}stiffness",)
