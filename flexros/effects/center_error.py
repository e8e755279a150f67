"""Error of the centre of mass of a body."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from pydantic import Field

from flexros.effects.kinds.model_change import AbstractChangedValues
from flexros.effects.kinds.ranges import Range
from flexros.effects.left_out.tool_load import seen_axes
from flexros.robot.symbolic.body_frame import moved_bodies

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.effects.kinds.base import Stage
    from flexros.robot import Robot

FIRST = 0.02
"""Initial offsets [m] (chosen), along one axis each."""
STARTS = {axis: tuple(FIRST * np.kron(np.eye(3)[k], [1.0, -1.0])) for k, axis in enumerate("xyz")}
"""Initial values of each coordinate, which belong together [m]."""


class CenterError(AbstractChangedValues):
    """The centre of mass of a body is elsewhere; its mass and its inertia about it are kept.

    Robot files have it on the line from joint to joint where housings, cables and counterweights move it off. A
    diagnosis seeks it where `--effects` names it: with its three numbers it imitates others on measured robots, as a
    wrong mass.
    """

    name: ClassVar[str] = "center_error"
    words: ClassVar[str] = "centre of mass error"
    stage: ClassVar[Stage] = "load"
    sought_where: ClassVar[str] = "in logs of real machines with torques, of arms without springs under gravity"
    together: ClassVar[bool] = True
    on_request: ClassVar[bool] = True
    signatures: ClassVar[tuple[str, ...]] = ("torque_over_position", "torque_over_acceleration", "frequency_response")
    fingerprint: ClassVar[str] = (
        "a disturbance torque in all joints that move the body, by its weight at another place, and by its acceleration"
    )

    ranges: ClassVar[Mapping[str, Range]] = MappingProxyType(
        {
            axis: Range("relative", 1e-3, 0.5, starts, signed=True, source="chosen [m]")
            for axis, starts in STARTS.items()
        }
    )

    x: float = Field(0.0, description="offset along x of the frame of the body [m]")
    y: float = Field(0.0, description="the same along y [m]")
    z: float = Field(0.0, description="the same along z [m]")

    def locations(self, robot: Robot) -> tuple[str, ...]:
        """Return the bodies that move and have a mass."""
        bodies = (f"body_{index + 1}" for index in moved_bodies(robot))
        return tuple(body for body in bodies if robot.parameters[f"{body}.mass"].value > 0)

    def sought(self, robot: Robot, location: str) -> bool:
        """Return False: a simulated robot has the bodies of its model."""
        del robot, location
        return False

    def sought_if_measured(self, robot: Robot, location: str) -> bool:
        """Return whether torques move a rigid arm under gravity.

        Springs blur what torques show of bodies. About a vertical axis, the first body is an inertia alone.
        """
        gravity = np.array(robot.spec.gravity.value)
        if robot.commands != "torque" or robot.flexible_motors or not gravity.any():
            return False
        first = robot.joints[0]
        upright = first.rotary and abs(gravity[first.axis]) == np.linalg.norm(gravity)
        return not (upright and location == f"body_{first.body + 1}")

    def fitted(self, robot: Robot, location: str) -> Mapping[str, Range]:
        """Return the coordinates but that along an axis about which all joints turn: nothing shows it."""
        return {axis: self.ranges[axis] for axis in seen_axes(robot, location)}

    def values(self, robot: Robot, location: str) -> dict[str, float]:
        """Return the centre of mass."""
        names = {axis: f"{location}.center_of_mass.{axis}" for axis in "xyz"}
        return {name: robot.parameters[name].value + float(getattr(self, axis)) for axis, name in names.items()}
