"""Error of the load: mass and inertia of the last body."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from pydantic import Field

from flexros.effects.base import AbstractEffect

if TYPE_CHECKING:
    from flexros.robot import Robot


class PayloadError(AbstractEffect):
    """Mass and inertia of the last body scaled together, the centre of mass kept."""

    name: ClassVar[str] = "payload_error"

    relative: float = Field(
        0.0, gt=-1.0, lt=10.0, description="error of mass and inertia, relative to the nominal value [1]"
    )

    def locations(self, robot: Robot) -> tuple[str, ...]:
        """Return the tool, the one place of the load."""
        del robot
        return ("tool",)

    def values(self, robot: Robot, location: str) -> dict[str, float]:
        """Scale mass and inertia of the last body."""
        del location
        last = f"body_{len(robot.spec.bodies)}"
        keys = (f"{last}.mass", f"{last}.inertia.")
        parameters = robot.parameters.values()
        return {p.name: (1 + self.relative) * p.value for p in parameters if p.name.startswith(keys)}
