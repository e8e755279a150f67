"""Error of the velocity feedforward of a servo."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

from pydantic import Field

from flexros.effects.kinds.model_change import AbstractChangedValues
from flexros.effects.kinds.ranges import Range
from flexros.errors import InputError
from flexros.robot.parameters import SERVO

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.effects.kinds.base import Stage
    from flexros.robot import Robot


class ServoFeedforwardError(AbstractChangedValues):
    """The share of the commanded speed that the damping of a position loop follows, beyond that of the robot file.

    With nominal share f and error s the torque is stiffness (command - q) + damping ((f + s) command' - q'). It is
    sought in logs with position commands only.
    """

    name: ClassVar[str] = "servo_feedforward_error"
    stage: ClassVar[Stage] = "actuator"
    signatures: ClassVar[tuple[str, ...]] = ("effective_torque", "time_shift")
    fingerprint: ClassVar[str] = (
        "the motor lags behind a moving command, or leads it, by an angle in proportion to the commanded speed, and is in "
        "place where the command rests"
    )
    ranges: ClassVar[Mapping[str, Range]] = MappingProxyType({"share": Range("relative", 0.01, 3.0, starts=5)})

    share: float = Field(
        0.0, ge=-10.0, le=10.0, description="beyond that of the robot file; below zero where that is too large [1]"
    )

    def locations(self, robot: Robot) -> tuple[str, ...]:
        """Return the motors whose servo has damping."""
        names = {name: robot.parameters.get(f"{name}.{SERVO}damping") for name in robot.joint_names}
        return tuple(name for name, gain in names.items() if gain is not None and gain.value > 0)

    def sought(self, robot: Robot, location: str) -> bool:
        """Return whether the robot is commanded by positions."""
        del location
        return robot.commands == "position"

    def fitted(self, robot: Robot, location: str) -> Mapping[str, Range]:
        """Return the range of the share, which takes away at most the nominal one."""
        nominal, allowed = _nominal(robot, location), self.ranges["share"]
        return {"share": replace(allowed, signed=True, negative=nominal) if nominal > 0 else allowed}

    def check_on(self, robot: Robot, location: str) -> None:
        """Refuse a share that takes away more than the nominal one."""
        nominal = _nominal(robot, location)
        if self.share < -nominal:
            raise InputError(
                f"{self.name}@{location}: share is {self.share:g}, but {robot.name} has a feedforward of {nominal:g} "
                f"there; give at least {-nominal:g}"
            )

    def values(self, robot: Robot, location: str) -> dict[str, float]:
        """Return the share with its error."""
        return {f"{location}.{SERVO}feedforward": _nominal(robot, location) + self.share}


def _nominal(robot: Robot, location: str) -> float:
    return robot.parameters[f"{location}.{SERVO}feedforward"].value
