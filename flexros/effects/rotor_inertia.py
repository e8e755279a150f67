"""Inertia of a rotor that the robot file leaves out."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

from pydantic import Field

from flexros.effects.kinds.model_change import AbstractChangedValues
from flexros.effects.kinds.ranges import Range

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.effects.kinds.base import Stage
    from flexros.robot import Robot


class RotorInertia(AbstractChangedValues):
    """Inertia of rotor and gear in a model that has none, such as one imported from a URDF.

    Seen through the gear, it is often larger than that of the bodies it moves.
    """

    name: ClassVar[str] = "rotor_inertia"
    stage: ClassVar[Stage] = "actuator"
    ranges: ClassVar[Mapping[str, Range]] = MappingProxyType({"added": Range("inertia", 1e-5, 10.0, starts=6)})
    signatures: ClassVar[tuple[str, ...]] = ("torque_over_acceleration", "frequency_response")
    fingerprint: ClassVar[str] = (
        "the disturbance torque is proportional to the acceleration of the motor, whatever the other joints do"
    )

    added: float = Field(0.0, ge=0.0, description="inertia at the joint, seen through the gear [kg m2, or kg]")

    def locations(self, robot: Robot) -> tuple[str, ...]:
        """Return the motors without inertia; an inertia that is wrong is a motor inertia error."""
        return tuple(name for name in robot.joint_names if robot.parameters[f"{name}.inertia"].value == 0)

    def values(self, robot: Robot, location: str) -> dict[str, float]:
        """Return the inertia of the motor."""
        name = f"{location}.inertia"
        return {name: robot.parameters[name].value + self.added}
