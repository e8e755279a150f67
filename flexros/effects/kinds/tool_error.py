"""Effects on the tool pose alone: the robot moves as ever, but its tool is not where the geometry says."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING, ClassVar

from flexros.effects.kinds.law import AbstractLaw

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.robot import Robot
    from flexros.robot.symbolic.kinematics import Value


class AbstractToolError(AbstractLaw):
    """A change of the kinematics from which the tool pose is computed; the dynamics stay.

    A member provides `name`, `stage`, `size`, its parameters, `locations` and `geometry`, and `offsets`
    where coordinates are off.
    """

    plain: ClassVar[bool] = True

    @abstractmethod
    def geometry(self, robot: Robot, location: str, values: Mapping[str, Value]) -> dict[str, Value]:
        """Give deviations of the geometry.

        Args:
            robot: The robot, for its nominal numbers.
            location: One of its `locations`.
            values: Number or symbol of every parameter of the effect by name.

        Returns:
            Deviations from the nominal numbers (SI) by parameter name, e.g. "body_2.length.x"; those of several effects
            add up. Empty where the geometry stays.
        """

    def offsets(self, robot: Robot, location: str, values: Mapping[str, Value]) -> dict[str, Value]:
        """Give offsets of arm coordinates.

        Args:
            robot: The robot.
            location: One of its `locations`.
            values: Number or symbol of every parameter of the effect by name.

        Returns:
            What is added to arm coordinates before the pose is computed [rad or m], by name, e.g. "body_2.ry".
        """
        del robot, location, values
        return {}
