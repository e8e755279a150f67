"""Error of the geometry, visible only in measurements of the tool."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

from pydantic import Field

from flexros.effects.kinds.ranges import Range
from flexros.effects.kinds.tool_error import AbstractToolError
from flexros.robot.symbolic.body_frame import long_axis, moved_bodies

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.effects.kinds.base import Stage
    from flexros.robot import Robot
    from flexros.robot.symbolic.kinematics import Value


class KinematicError(AbstractToolError):
    """A body of another length or mounting angle: the dynamics are nominal, the tool pose is not.

    The length vector of the body is longer by `length` (along the x axis where it has none), and the coordinate by
    which the body rotates (the one with the motor, else the first) has a zero that is wrong by `angle`: the measured
    tool pose is that of the arm with l + length and q + angle. A tool point given separately in the robot file
    (`tool.position`) does not move with the length of the last body. A diagnosis does not fit the angle of the first
    body, because the unknown frame of a tool tracker absorbs it.

    Reference: Hollerbach, Khalil, Gautier 2016, Springer Handbook of Robotics, chapter 8: model calibration.
    """

    name: ClassVar[str] = "kinematic_error"
    stage: ClassVar[Stage] = "sensor"
    size: ClassVar[str] = "length"
    further_sizes: ClassVar[tuple[str, ...]] = ("angle",)
    ranges: ClassVar[Mapping[str, Range]] = MappingProxyType(
        {
            "length": Range("relative", 1e-5, 0.1, 2, signed=True, source="chosen [m]"),
            "angle": Range("relative", 1e-5, 0.1, 2, signed=True, source="chosen [rad]"),
        }
    )
    signatures: ClassVar[tuple[str, ...]] = ("tool_error",)
    fingerprint: ClassVar[str] = (
        "a tool error that depends on the pose alone, while all motor positions and torques are as the model says"
    )

    length: float = Field(0.0, description="additional length of the body [m]")
    angle: float = Field(0.0, description="error of the zero of its rotation [rad]")

    def locations(self, robot: Robot) -> tuple[str, ...]:
        """Return the bodies that rotate, on robots whose tool has a geometry."""
        if robot.spec.tool.linear:
            return ()
        bodies = moved_bodies(robot)
        return tuple(f"body_{body + 1}" for body in bodies if _turning(robot, body))

    def fitted(self, robot: Robot, location: str) -> Mapping[str, Range]:
        """Return the ranges without the angle of the first body, which is the orientation of the tracker's frame."""
        first = moved_bodies(robot)[0]
        return {name: allowed for name, allowed in self.ranges.items() if name != "angle" or _number(location) != first}

    def geometry(self, robot: Robot, location: str, values: Mapping[str, Value]) -> dict[str, Value]:
        """Lengthen the body."""
        direction = long_axis(robot, _number(location))
        return {
            f"{location}.length.{axis}": values["length"] * float(part)
            for axis, part in zip("xyz", direction)
            if part != 0
        }

    def offsets(self, robot: Robot, location: str, values: Mapping[str, Value]) -> dict[str, Value]:
        """Turn the body."""
        return {_turning(robot, _number(location))[0]: values["angle"]}


def _number(location: str) -> int:
    return int(location.removeprefix("body_")) - 1


def _turning(robot: Robot, body: int) -> tuple[str, ...]:
    """Return the coordinates by which a body rotates, the one with the motor first."""
    joints = [joint for joint in robot.joints if joint.body == body and joint.rotary]
    return tuple(joint.name for joint in sorted(joints, key=lambda joint: joint.motor is None))
