"""Error of a damper."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from pydantic import Field

from flexros.effects.base import AbstractEffect

if TYPE_CHECKING:
    from flexros.robot import Robot


class DampingError(AbstractEffect):
    """The damper beside one spring scaled."""

    name: ClassVar[str] = "damping_error"

    relative: float = Field(
        0.0, gt=-1.0, lt=10.0, description="error of the damping, relative to the nominal value [1]"
    )

    def locations(self, robot: Robot) -> tuple[str, ...]:
        """List the springs, each of which has a damper."""
        return tuple(name for name in robot.arm_names if f"{name}.damping" in robot.parameters)

    def values(self, robot: Robot, location: str) -> dict[str, float]:
        """Scale the damper beside a spring."""
        name = f"{location}.damping"
        return {name: (1 + self.relative) * robot.parameters[name].value}
