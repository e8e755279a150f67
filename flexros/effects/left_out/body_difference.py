"""Mass, centre of mass and inertia of a body that differ from those of the robot file."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from pydantic import Field

from flexros.effects.kinds.model_change import AbstractChangedValues
from flexros.robot.parameters import INERTIA_COMPONENTS

if TYPE_CHECKING:
    from flexros.effects.kinds.base import Stage
    from flexros.robot import Robot


class BodyDifference(AbstractChangedValues):
    """Differences of the numbers of a body from those of the robot file.

    Some robot files have rough numbers, or those of another version: far more than their tolerance. A diagnosis of a
    measured log then estimates them all at once. Where the mass of the last body alone is wrong, that is a payload
    error; a mass that was left out is a load.
    """

    name: ClassVar[str] = "body_difference"
    stage: ClassVar[Stage] = "load"
    signatures: ClassVar[tuple[str, ...]] = ("torque_over_position", "torque_over_acceleration", "frequency_response")
    fingerprint: ClassVar[str] = "disturbance torques in all joints up to the body, by its weight and its acceleration"

    mass: float = Field(0.0, description="difference of the mass [kg]")
    x: float = Field(0.0, description="of the centre of mass, along x of the frame of the body [m]")
    y: float = Field(0.0, description="the same along y [m]")
    z: float = Field(0.0, description="the same along z [m]")
    xx: float = Field(0.0, description="of the inertia about the centre of mass and the axis x [kg m2]")
    yy: float = Field(0.0, description="the same about y [kg m2]")
    zz: float = Field(0.0, description="the same about z [kg m2]")
    xy: float = Field(0.0, description="of the product of inertia [kg m2]")
    xz: float = Field(0.0, description="the same [kg m2]")
    yz: float = Field(0.0, description="the same [kg m2]")

    def locations(self, robot: Robot) -> tuple[str, ...]:
        """Return the bodies."""
        return tuple(f"body_{number}" for number in range(1, len(robot.spec.bodies) + 1))

    def values(self, robot: Robot, location: str) -> dict[str, float]:
        """Return the numbers of the body that differ."""
        differences = {"mass": self.mass}
        differences |= {f"center_of_mass.{axis}": float(getattr(self, axis)) for axis in "xyz"}
        differences |= {f"inertia.{entry}": float(getattr(self, entry)) for entry in INERTIA_COMPONENTS}
        names = {f"{location}.{name}": difference for name, difference in differences.items() if difference}
        return {name: robot.parameters[name].value + difference for name, difference in names.items()}
