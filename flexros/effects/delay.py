"""Delay of the commands."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

from pydantic import Field

from flexros.effects.kinds.law import AbstractLaw
from flexros.effects.kinds.model_change import AbstractChangedValues
from flexros.effects.kinds.ranges import Range

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.effects.kinds.base import Stage
    from flexros.robot import Robot


class Delay(AbstractChangedValues, AbstractLaw):
    """Delay of the commands beyond the nominal one; any real number of samples.

    At "all" it adds to the delay of the robot; at a motor it delays the commands of that motor alone.
    """

    name: ClassVar[str] = "delay"
    stage: ClassVar[Stage] = "timing"
    size: ClassVar[str] = "time"
    signatures: ClassVar[tuple[str, ...]] = ("time_shift", "detection_lines")
    delays_commands: ClassVar[bool] = True
    fingerprint: ClassVar[str] = (
        "all responses are late by the same time: prediction errors follow torque changes, the phase falls in "
        "proportion to frequency and the magnitude is unchanged"
    )
    ranges: ClassVar[Mapping[str, Range]] = MappingProxyType(
        {"time": Range("time", 1e-6, 0.09, starts=10, source="stacks of 1 to 10 ms; servos at 50 Hz a few samples")}
    )

    time: float = Field(0.0, ge=0.0, le=0.1, description="additional delay of the command [s]")

    def locations(self, robot: Robot) -> tuple[str, ...]:
        """Return "all", and each motor where there are several."""
        return ("all", *robot.joint_names) if robot.n_motors > 1 else ("all", "motor_1")

    def changes_model(self, location: str) -> bool:
        """Return whether it is the delay of all motors, a parameter of the robot."""
        return location == "all"

    @property
    def parameter_values(self) -> dict[str, float]:
        """Return none: a delay splits sample intervals and cannot be a symbol."""
        return {}

    def values(self, robot: Robot, location: str) -> dict[str, float]:
        """Return the longer delay."""
        del location
        return {"delay": robot.delay + self.time}
