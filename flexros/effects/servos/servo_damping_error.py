"""Error of the damping of a servo."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from flexros.effects.kinds.relative_error import AbstractRelativeError
from flexros.effects.kinds.servo_number import gains_are_known
from flexros.robot.parameters import SERVO

if TYPE_CHECKING:
    from flexros.effects.kinds.base import Stage
    from flexros.robot import Robot


class ServoDampingError(AbstractRelativeError):
    """The gain of a position loop on the speed scaled.

    It is sought in logs with position commands only, and where the damping follows the rate of the command. Elsewhere
    it acts as viscous friction does, which is the name given then, unless the servo reaches its torque limit.
    """

    name: ClassVar[str] = "servo_damping_error"
    stage: ClassVar[Stage] = "actuator"
    signatures: ClassVar[tuple[str, ...]] = ("effective_torque", "torque_over_speed")
    fingerprint: ClassVar[str] = (
        "the errors are proportional to the difference between commanded and measured speed of the motor"
    )

    def locations(self, robot: Robot) -> tuple[str, ...]:
        """Return the motors whose servo has damping."""
        names = {name: robot.parameters.get(f"{name}.{SERVO}damping") for name in robot.joint_names}
        return tuple(name for name, gain in names.items() if gain is not None and gain.value > 0)

    def sought(self, robot: Robot, location: str) -> bool:
        """Return whether the robot is commanded by positions whose rate an uncertain servo follows."""
        if robot.commands != "position" or gains_are_known(robot, location):
            return False
        return robot.parameters[f"{location}.{SERVO}feedforward"].value > 0

    def numbers(self, robot: Robot, location: str) -> tuple[str, ...]:
        """Return the damping of the servo."""
        del robot
        return (f"{location}.{SERVO}damping",)
