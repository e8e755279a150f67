"""Errors of a number of servos that may be zero in the robot file."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING, ClassVar

from flexros.effects.kinds.model_change import AbstractChangedValues
from flexros.errors import InputError
from flexros.robot.parameters import SERVO

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flexros.effects.kinds.base import AbstractEffect
    from flexros.robot import Robot


def gains_are_known(robot: Robot, motor: str) -> bool:
    """Return whether the robot file says that the gains of a motor's servo are known."""
    servo = robot.motors[robot.joint_names.index(motor)].specification.servo
    return servo is not None and servo.known


def servo_motors(robot: Robot) -> tuple[str, ...]:
    """Return the motors with a servo."""
    return tuple(name for name in robot.joint_names if f"{name}.{SERVO}stiffness" in robot.parameters)


def gains_are_sought(robot: Robot, motor: str) -> bool:
    """Return whether the robot is commanded by positions and the gains of a motor's servo are not known."""
    return robot.commands == "position" and not gains_are_known(robot, motor)


class AbstractServoNumber(AbstractChangedValues):
    """A number of a servo beyond that of the robot file, from which it takes away at most what is there.

    A member provides `name`, `stage`, `size`, `number`, and its parameter as `added`.
    """

    seeks_less: ClassVar[bool] = True
    sought_where: ClassVar[str] = "in logs with position commands, at servos whose gains are not stated as known"
    size: ClassVar[str]
    """Its parameter, zero where it is switched off."""
    number: ClassVar[str]
    """The number of the servo, a key of `servo` in the robot file."""

    @property
    @abstractmethod
    def added(self) -> float:
        """What is added to the number of the robot file [its unit]."""

    def locations(self, robot: Robot) -> tuple[str, ...]:
        """Return the motors with a servo."""
        return servo_motors(robot)

    def sought(self, robot: Robot, location: str) -> bool:
        """Return whether the robot is commanded by positions and the gains are not known."""
        return gains_are_sought(robot, location)

    def reductions(self, robot: Robot, location: str, known: Sequence[AbstractEffect] = ()) -> Mapping[str, float]:
        """Return the number in the robot file, which is all that can be taken away."""
        del known
        return {self.size: self.nominal(robot, location)}

    def check_on(self, robot: Robot, location: str) -> None:
        """Refuse a value that takes away more than the robot file has."""
        nominal = self.nominal(robot, location)
        if self.added < -nominal:
            raise InputError(
                f"{self.name}@{location}: {self.size} is {self.added:g}, but the {self.number} of the servo is "
                f"{nominal:g} in {robot.name}; give at least {-nominal:g}"
            )

    def nominal(self, robot: Robot, location: str) -> float:
        """Return the number in the robot file."""
        return robot.parameters[f"{location}.{SERVO}{self.number}"].value

    def values(self, robot: Robot, location: str) -> dict[str, float]:
        """Return the number with its error."""
        return {f"{location}.{SERVO}{self.number}": self.nominal(robot, location) + self.added}
