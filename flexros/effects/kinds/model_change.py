"""Effects that change the robot's model: its numbers, or the form of one of its laws."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING, ClassVar

from flexros.effects.kinds.base import AbstractEffect

if TYPE_CHECKING:
    from flexros.robot import Robot


class AbstractModelChange(AbstractEffect):
    """An effect that is another robot file: whatever holds of a robot holds of the plant with it.

    Equilibrium under gravity, energy, linearisation and identified parameters of the plant then include the effect.

    A member provides `name`, `stage`, its parameters, `locations` and `changed`.
    """

    def changes_model(self, location: str) -> bool:
        """Tell whether the effect is another robot file at a place; where not, it is a law there as well."""
        del location
        return True

    @abstractmethod
    def changed(self, robot: Robot, location: str) -> Robot:
        """Change the robot; with neutral parameters it stays what it is.

        Args:
            robot: The robot without the effect.
            location: One of its `locations`.

        Returns:
            The robot with the effect.
        """


class AbstractChangedValues(AbstractModelChange):
    """An effect that changes numbers of the robot.

    A member provides `name`, `stage`, its parameters, `locations` and `values`.
    """

    plain: ClassVar[bool] = True

    @abstractmethod
    def values(self, robot: Robot, location: str) -> dict[str, float]:
        """Compute the changed numbers of the robot.

        Args:
            robot: The robot without the effect.
            location: One of its `locations`.

        Returns:
            New values (SI) by parameter name, as for `Robot.with_values`.
        """

    def changed(self, robot: Robot, location: str) -> Robot:
        """Put the changed numbers into the robot."""
        return robot.with_values(self.values(robot, location), self.name)
