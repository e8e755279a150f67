"""Error of the inertia of a body."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, ClassVar

from flexros.effects.kinds.relative_error import AbstractRelativeError
from flexros.robot.symbolic.body_frame import moved_bodies

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.effects.kinds.base import Stage
    from flexros.effects.kinds.ranges import Range
    from flexros.robot import Robot

REDUCED = (-0.2, -0.5, -0.8)
"""Initial values where only a smaller inertia is sought [1] (chosen)."""


class InertiaError(AbstractRelativeError):
    """The inertia of a body about its centre of mass scaled; mass and centre of mass are kept.

    It is several times too large where the inertia about a joint was written in place of that about the centre of mass.
    """

    name: ClassVar[str] = "inertia_error"
    stage: ClassVar[Stage] = "load"
    sought_where: ClassVar[str] = "in logs of real machines with torques, of arms without springs"
    signatures: ClassVar[tuple[str, ...]] = ("torque_over_acceleration", "frequency_response")
    fingerprint: ClassVar[str] = (
        "disturbance torques in all joints that turn the body, by its angular acceleration; its weight is right"
    )

    def locations(self, robot: Robot) -> tuple[str, ...]:
        """Return the bodies that move and have an inertia."""
        bodies = (f"body_{index + 1}" for index in moved_bodies(robot))
        return tuple(body for body in bodies if any(robot.parameters[name].value for name in self.numbers(robot, body)))

    def sought(self, robot: Robot, location: str) -> bool:
        """Return False: a simulated robot has the bodies of its model."""
        del robot, location
        return False

    def sought_if_measured(self, robot: Robot, location: str) -> bool:
        """Return whether torques move a rigid arm, and no inertia of a motor does what this one does.

        Springs blur what torques show of bodies. To the first motor, its inertia and that of the first body are one.
        """
        if robot.commands != "torque" or robot.flexible_motors:
            return False
        first = robot.joints[0].body + 1
        return location != f"body_{first}" or lacks_rotor(robot, location)

    def fitted(self, robot: Robot, location: str) -> Mapping[str, Range]:
        """Return the range; without positive values where the motor of the body has no inertia, which is missing then.

        To its own motor a body with more inertia is one with a rotor.
        """
        if not lacks_rotor(robot, location):
            return self.ranges
        return {"relative": replace(self.ranges["relative"], starts=REDUCED, positive=0.0)}

    def numbers(self, robot: Robot, location: str) -> tuple[str, ...]:
        """Return the entries of the inertia of the body."""
        return tuple(name for name in robot.parameters if name.startswith(f"{location}.inertia."))


def lacks_rotor(robot: Robot, body: str) -> bool:
    """Return whether the motor of the joint that moves a body has no inertia.

    Args:
        robot: The robot.
        body: The body, e.g. "body_2".
    """
    index = int(body.removeprefix("body_")) - 1
    motor = [joint.motor for joint in robot.joints if joint.body <= index and joint.motor is not None][-1]
    return robot.motors[motor].specification.inertia.value == 0
