"""Error of a motor's inertia."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from flexros.effects.kinds.relative_error import AbstractRelativeError

if TYPE_CHECKING:
    from flexros.effects.kinds.base import Stage
    from flexros.robot import Robot


class MotorInertiaError(AbstractRelativeError):
    """The inertia of one rotor scaled."""

    name: ClassVar[str] = "motor_inertia_error"
    stage: ClassVar[Stage] = "actuator"
    signatures: ClassVar[tuple[str, ...]] = ("torque_over_acceleration", "frequency_response")
    fingerprint: ClassVar[str] = (
        "the disturbance torque is proportional to the acceleration of the motor, also above the resonance of the joint"
    )

    def locations(self, robot: Robot) -> tuple[str, ...]:
        """Return the motors whose inertia is not zero."""
        return tuple(name for name in robot.joint_names if robot.parameters[f"{name}.inertia"].value > 0)

    def scaled(self, robot: Robot, location: str) -> tuple[str, ...]:
        """Return the inertia of the motor."""
        del robot
        return (f"{location}.inertia",)
