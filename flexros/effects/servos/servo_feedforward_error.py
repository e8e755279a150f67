"""Error of the velocity feedforward of a servo."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

from pydantic import Field

from flexros.effects.kinds.ranges import Range
from flexros.effects.kinds.servo_number import AbstractServoNumber
from flexros.robot.parameters import SERVO

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.effects.kinds.base import Stage
    from flexros.robot import Robot


class ServoFeedforwardError(AbstractServoNumber):
    """The share of the commanded speed that the damping of a position loop follows, beyond that of the robot file.

    With nominal share f and error s the torque is stiffness (command - q) + damping ((f + s) command' - q'). It is
    sought in logs with position commands only.
    """

    name: ClassVar[str] = "servo_feedforward_error"
    stage: ClassVar[Stage] = "actuator"
    size: ClassVar[str] = "share"
    number: ClassVar[str] = "feedforward"
    signatures: ClassVar[tuple[str, ...]] = ("effective_torque", "time_shift")
    fingerprint: ClassVar[str] = (
        "the motor lags behind a moving command, or leads it, by an angle in proportion to the commanded speed, and is "
        "in place where the command rests"
    )
    ranges: ClassVar[Mapping[str, Range]] = MappingProxyType({"share": Range("relative", 0.01, 3.0, starts=5)})

    share: float = Field(
        0.0, ge=-10.0, le=10.0, description="beyond that of the robot file; below zero where that is too large [1]"
    )

    def locations(self, robot: Robot) -> tuple[str, ...]:
        """Return the motors whose servo has damping."""
        return tuple(name for name in super().locations(robot) if robot.parameters[f"{name}.{SERVO}damping"].value > 0)

    @property
    def added(self) -> float:
        """The share."""
        return self.share
