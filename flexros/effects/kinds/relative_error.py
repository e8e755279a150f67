"""Relative errors of parameters of the model."""

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
    """Parameters of the model scaled by one factor: value = (1 + relative) times nominal.

    A member provides `name`, `stage`, `locations` and `numbers`.
    """

    ranges: ClassVar[Mapping[str, Range]] = MappingProxyType(
        {"relative": Range("relative", 0.003, 9.0, starts=6, signed=True, negative=0.9)}
    )

    relative: float = Field(0.0, gt=-1.0, lt=1000.0, description="deviation, relative to the nominal value [1]")

    @abstractmethod
    def numbers(self, robot: Robot, location: str) -> tuple[str, ...]:
        """Return the names of the scaled parameters at one of its `locations`, as for `Robot.with_values`."""

    def values(self, robot: Robot, location: str) -> dict[str, float]:
        """Return the scaled values."""
        return {name: (1 + self.relative) * robot.parameters[name].value for name in self.numbers(robot, location)}
