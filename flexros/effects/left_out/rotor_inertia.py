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

    Seen through the gear, it is often larger than that of the bodies it moves. A diagnosis estimates it where the file
    gives none: as a number that is unknown where the torques show it clearly, else as a candidate like others. Where
    the file gives one, an error of it is a motor inertia error.
    """

    name: ClassVar[str] = "rotor_inertia"
    stage: ClassVar[Stage] = "actuator"
    signatures: ClassVar[tuple[str, ...]] = ("torque_over_acceleration", "frequency_response")
    fingerprint: ClassVar[str] = (
        "the disturbance torque is proportional to the acceleration of the motor, whatever the other joints do"
    )

    ranges: ClassVar[Mapping[str, Range]] = MappingProxyType(
        {"added": Range("relative", 1e-6, 10.0, 7, source="chosen [kg m2 or kg]: from a hobby servo to a large arm")}
    )

    added: float = Field(0.0, ge=0.0, description="inertia at the joint, seen through the gear [kg m2 or kg]")

    def locations(self, robot: Robot) -> tuple[str, ...]:
        """Return the motors."""
        return robot.joint_names

    def sought(self, robot: Robot, location: str) -> bool:
        """Return False: a simulated robot has the rotors of its model."""
        del robot, location
        return False

    def sought_if_measured(self, robot: Robot, location: str) -> bool:
        """Return whether the model has no inertia of the motor: the torques did not show it clearly."""
        return robot.parameters[f"{location}.inertia"].value == 0

    def values(self, robot: Robot, location: str) -> dict[str, float]:
        """Return the inertia of the motor."""
        name = f"{location}.inertia"
        return {name: robot.parameters[name].value + self.added}
