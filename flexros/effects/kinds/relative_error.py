"""What the errors of model numbers have in common: a relative deviation."""

from __future__ import annotations

from abc import abstractmethod
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

from pydantic import Field

from flexros.effects.kinds.model_change import AbstractChangedValues
from flexros.effects.kinds.ranges import Range

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.robot import Robot


class AbstractRelativeError(AbstractChangedValues):
    """Numbers of the model that are wrong by one factor: value = (1 + relative) times nominal.

    A member provides `name`, `stage`, `locations` and `scaled`.
    """

    ranges: ClassVar[Mapping[str, Range]] = MappingProxyType(
        {"relative": Range("relative", 0.003, 9.0, starts=6, signed=True, negative=0.9)}
    )

    relative: float = Field(0.0, gt=-1.0, lt=10.0, description="deviation, relative to the nominal value [1]")

    @abstractmethod
    def scaled(self, robot: Robot, location: str) -> tuple[str, ...]:
        """List the numbers that are scaled.

        Args:
            robot: The robot without the effect.
            location: One of its `locations`.

        Returns:
            Parameter names, as for `Robot.with_values`.
        """

    def values(self, robot: Robot, location: str) -> dict[str, float]:
        """Scale the numbers."""
        return {name: (1 + self.relative) * robot.parameters[name].value for name in self.scaled(robot, location)}
