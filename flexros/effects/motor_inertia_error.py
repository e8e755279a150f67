"""Error of a motor's inertia."""

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


class MotorInertiaError(AbstractRelativeError):
    """The inertia of one rotor scaled.

    Seen through the gear, a file that counts the rotor alone, or the link alone, may be far off.
    """

    name: ClassVar[str] = "motor_inertia_error"
    stage: ClassVar[Stage] = "actuator"
    signatures: ClassVar[tuple[str, ...]] = ("torque_over_acceleration", "frequency_response")
    fingerprint: ClassVar[str] = (
        "the disturbance torque is proportional to the acceleration of the motor, also above the resonance of the joint"
    )

    relative: float = Field(0.0, gt=-1.0, lt=1000.0, description="deviation, relative to the nominal value [1]")

    ranges: ClassVar[Mapping[str, Range]] = MappingProxyType(
        {"relative": replace(AbstractRelativeError.ranges["relative"], widest=900.0)}
    )

    def locations(self, robot: Robot) -> tuple[str, ...]:
        """Return the motors whose inertia is not zero."""
        return tuple(name for name in robot.joint_names if robot.parameters[f"{name}.inertia"].value > 0)

    def numbers(self, robot: Robot, location: str) -> tuple[str, ...]:
        """Return the inertia of the motor."""
        del robot
        return (f"{location}.inertia",)
