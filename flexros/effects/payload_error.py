"""Error of the load: mass and inertia of the last body."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

from pydantic import Field

from flexros.effects.kinds.relative_error import AbstractRelativeError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.effects.kinds.base import Stage
    from flexros.effects.kinds.ranges import Range
    from flexros.robot import Robot


class PayloadError(AbstractRelativeError):
    """Mass and inertia of the last body scaled together, the centre of mass kept.

    The last body of a wrist is light: what it carries may be many times its mass.
    """

    name: ClassVar[str] = "payload_error"
    stage: ClassVar[Stage] = "load"
    signatures: ClassVar[tuple[str, ...]] = (
        "torque_over_acceleration",
        "frequency_response",
        "torque_over_position",
        "tool_error",
    )
    fingerprint: ClassVar[str] = (
        "a disturbance torque in all joints that follows the acceleration of the tool, and its weight under gravity"
    )

    relative: float = Field(0.0, gt=-1.0, lt=1000.0, description="deviation, relative to the nominal value [1]")

    ranges: ClassVar[Mapping[str, Range]] = MappingProxyType(
        {"relative": replace(AbstractRelativeError.ranges["relative"], widest=900.0)}
    )

    def locations(self, robot: Robot) -> tuple[str, ...]:
        """Return the tool, the only location of the load; none where the last body is a frame without mass."""
        return ("tool",) if any(robot.parameters[name].value for name in self.numbers(robot, "tool")) else ()

    def numbers(self, robot: Robot, location: str) -> tuple[str, ...]:
        """Return mass and inertia of the last body."""
        del location
        last = f"body_{len(robot.spec.bodies)}"
        return tuple(name for name in robot.parameters if name.startswith((f"{last}.mass", f"{last}.inertia.")))
