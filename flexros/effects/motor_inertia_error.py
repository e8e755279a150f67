"""Error of a motor's inertia."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from pydantic import Field

from flexros.effects.base import AbstractEffect

if TYPE_CHECKING:
    from flexros.robot import Robot


class MotorInertiaError(AbstractEffect):
    """The inertia of one rotor scaled."""

    name: ClassVar[str] = "motor_inertia_error"

    relative: float = Field(
        0.0, gt=-1.0, lt=10.0, description="error of the rotor inertia, relative to the nominal value [1]"
    )

    def locations(self, robot: Robot) -> tuple[str, ...]:
        """List the motors that have an inertia of their own."""
        return tuple(name for name in robot.joint_names if robot.parameters[f"{name}.inertia"].value > 0)

    def values(self, robot: Robot, location: str) -> dict[str, float]:
        """Scale the inertia of a motor."""
        name = f"{location}.inertia"
        return {name: (1 + self.relative) * robot.parameters[name].value}
