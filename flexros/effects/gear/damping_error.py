"""Error of a damper."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from flexros.effects.kinds.relative_error import AbstractRelativeError

if TYPE_CHECKING:
    from flexros.effects.kinds.base import Stage
    from flexros.robot import Robot


class DampingError(AbstractRelativeError):
    """The damper parallel to one spring scaled."""

    name: ClassVar[str] = "damping_error"
    stage: ClassVar[Stage] = "gear"
    signatures: ClassVar[tuple[str, ...]] = ("frequency_response", "detection_lines")
    fingerprint: ClassVar[str] = (
        "vibrations of the joint decay faster or slower, and only the height of resonance peaks changes"
    )

    def locations(self, robot: Robot) -> tuple[str, ...]:
        """Return the springs, each of which has a damper."""
        return tuple(name for name in robot.arm_names if f"{name}.damping" in robot.parameters)

    def numbers(self, robot: Robot, location: str) -> tuple[str, ...]:
        """Return the damper parallel to the spring."""
        del robot
        return (f"{location}.damping",)
