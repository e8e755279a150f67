"""Delay of the commands."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from pydantic import Field

from flexros.effects.model_change import AbstractChangedValues

if TYPE_CHECKING:
    from flexros.effects.base import Stage
    from flexros.robot import Robot


class Delay(AbstractChangedValues):
    """Time that all commands take to act, beyond the nominal delay; any real number of samples."""

    name: ClassVar[str] = "delay"
    stage: ClassVar[Stage] = "timing"

    time: float = Field(0.0, ge=0.0, le=0.1, description="additional delay of the command [s]")

    def locations(self, robot: Robot) -> tuple[str, ...]:
        """Return "all": the command line of all motors is one."""
        del robot
        return ("all",)

    def values(self, robot: Robot, location: str) -> dict[str, float]:
        """Lengthen the delay."""
        del location
        return {"delay": robot.delay + self.time}
