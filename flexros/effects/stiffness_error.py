"""Error of a spring's stiffness."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from pydantic import Field

from flexros.effects.base import AbstractEffect

if TYPE_CHECKING:
    from flexros.robot import Robot


class StiffnessError(AbstractEffect):
    """The whole law of one spring scaled, linear or not."""

    name: ClassVar[str] = "stiffness_error"

    relative: float = Field(
        0.0, gt=-1.0, lt=10.0, description="error of the stiffness, relative to the nominal value [1]"
    )

    def locations(self, robot: Robot) -> tuple[str, ...]:
        """List the springs."""
        return tuple(name for name in robot.arm_names if f"{name}.stiffness" in robot.parameters)

    def values(self, robot: Robot, location: str) -> dict[str, float]:
        """Scale the stiffness of a spring."""
        name = f"{location}.stiffness"
        return {name: (1 + self.relative) * robot.parameters[name].value}
