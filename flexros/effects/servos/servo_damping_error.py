"""Error of the damping of a servo."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

from flexros.effects.kinds.ranges import Range
from flexros.effects.kinds.relative_error import AbstractRelativeError
from flexros.effects.kinds.servo_number import gains_are_sought
from flexros.robot.parameters import SERVO

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.effects.kinds.base import Stage
    from flexros.robot import Robot


_LESS: Mapping[str, Range] = MappingProxyType(
    {"relative": Range("relative", 0.003, 0.9, starts=(-0.03, -0.3), signed=True, positive=0.0)}
)


class ServoDampingError(AbstractRelativeError):
    """The gain of a position loop on the speed scaled.

    It is sought in logs with position commands only. Where the damping does not follow the rate of the command, it acts
    as viscous friction does: more of it has that name then, unless the servo reaches its torque limit, and less of it
    this one.
    """

    name: ClassVar[str] = "servo_damping_error"
    stage: ClassVar[Stage] = "actuator"
    sought_where: ClassVar[str] = "in logs with position commands, at servos whose gains are not stated as known"
    signatures: ClassVar[tuple[str, ...]] = ("effective_torque", "torque_over_speed")
    fingerprint: ClassVar[str] = (
        "the errors are proportional to the difference between commanded and measured speed of the motor"
    )

    def locations(self, robot: Robot) -> tuple[str, ...]:
        """Return the motors whose servo has damping."""
        names = {name: robot.parameters.get(f"{name}.{SERVO}damping") for name in robot.joint_names}
        return tuple(name for name, gain in names.items() if gain is not None and gain.value > 0)

    def sought(self, robot: Robot, location: str) -> bool:
        """Return whether the robot is commanded by positions and the gains are not known."""
        return gains_are_sought(robot, location)

    def fitted(self, robot: Robot, location: str) -> Mapping[str, Range]:
        """Return the range of its size, of both signs where the damping follows the rate of the command."""
        return self.ranges if robot.parameters[f"{location}.{SERVO}feedforward"].value > 0 else _LESS

    def numbers(self, robot: Robot, location: str) -> tuple[str, ...]:
        """Return the damping of the servo."""
        del robot
        return (f"{location}.{SERVO}damping",)
