"""Effects on the tool pose alone: errors of the geometry that leave the dynamics unchanged."""

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

    A member provides `name`, `stage`, `size`, its parameters, `locations` and `geometry`, and for offsets of arm
    coordinates `offsets`.
    """

    plain: ClassVar[bool] = True
    sought_where: ClassVar[str] = "in logs with measured tool poses"

    @abstractmethod
    def geometry(self, robot: Robot, location: str, values: Mapping[str, Value]) -> dict[str, Value]:
        """Return deviations of the geometry.

        Args:
            robot: The nominal robot.
            location: One of its `locations`.
            values: Value or symbol of every parameter of the effect, by name.

        Returns:
            Deviations from the nominal values (SI) by parameter name, e.g. "body_2.length.x"; those of several effects
            add up. Empty where the geometry is nominal.
        """

    def offsets(self, robot: Robot, location: str, values: Mapping[str, Value]) -> dict[str, Value]:
        """Return offsets of arm coordinates in the pose [rad or m] by name, e.g. "body_2.ry"; see `geometry`."""
        del robot, location, values
        return {}
