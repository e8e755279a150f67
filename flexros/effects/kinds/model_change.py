"""Effects that change the robot's model: parameter values, or the form of one of its laws."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING, ClassVar

from flexros.effects.kinds.base import AbstractEffect

if TYPE_CHECKING:
    from flexros.robot import Robot


class AbstractModelChange(AbstractEffect):
    """An effect that is equivalent to another robot file.

    Equilibrium under gravity, energy, linearisation and identified parameters of the plant then include the effect.

    A member provides `name`, `stage`, its parameters, `locations` and `changed`.
    """

    def changes_model(self, location: str) -> bool:
        """Return whether the effect changes the robot file at a location; where not, it is a law."""
        del location
        return True

    @abstractmethod
    def changed(self, robot: Robot, location: str) -> Robot:
        """Return the robot with the effect at one of its `locations`; neutral parameters leave it unchanged."""


class AbstractChangedValues(AbstractModelChange):
    """An effect that changes parameter values of the robot.

    A member provides `name`, `stage`, its parameters, `locations` and `values`.
    """

    plain: ClassVar[bool] = True

    @abstractmethod
    def values(self, robot: Robot, location: str) -> dict[str, float]:
        """Return the new values (SI) by parameter name, as for `Robot.with_values`.

        Args:
            robot: The robot without the effect.
            location: One of its `locations`.
        """

    def numbers(self, robot: Robot, location: str) -> tuple[str, ...]:
        """Return the names of the parameters with new values."""
        return tuple(self.values(robot, location))

    def changed(self, robot: Robot, location: str) -> Robot:
        """Return the robot with the new values."""
        return robot.with_values(self.values(robot, location), self.name)
