"""The axes of an arm from an MJCF: motors with rigid or elastic gears, and directions without a motor."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.robot.exchange.mjcf.actuators import JointActuator, joint_actuator

if TYPE_CHECKING:
    from flexros.robot.exchange.mjcf.arm import ArmJoint, MjcfArm

WEIGHTLESS = 1e-5
"""Mass of a rotor's own body over that of the next one, and its inertia over the armature, that are none (chosen)."""
COAXIAL = 1e-9
"""Largest distance of the anchors of two joints that are one axis [m] (chosen)."""


@dataclass(frozen=True, eq=False)
class ArmAxis:
    """One axis of the arm, a body of the robot file.

    Attributes:
        coordinate: Motor, or arm coordinate of a joint without an actuator.
        number: Number of the body in the robot file, from 1.
        joint: The joint, that of the motor.
        deflection: The joint behind it whose position is the deflection of an elastic gear; None for a rigid gear.
        actuator: What drives the joint; None without an actuator.
        is_motor: Whether it is a motor.
    """

    coordinate: str
    number: int
    joint: ArmJoint
    deflection: ArmJoint | None
    actuator: JointActuator | None
    is_motor: bool

    @property
    def direction(self) -> str:
        """Direction in the robot file, e.g. "ry"."""
        return ("r" if self.joint.rotary else "t") + "xyz"[self.joint.axis]

    @property
    def arm_coordinate(self) -> str:
        """Arm coordinate, e.g. "body_2.ry"."""
        return f"body_{self.number}.{self.direction}"

    @property
    def carrier(self) -> ArmJoint:
        """The joint that carries the bodies."""
        return self.joint if self.deflection is None else self.deflection


def axes_of(model: Any, arm: MjcfArm) -> tuple[ArmAxis, ...]:
    """Return the axes of an arm from base to end.

    A joint with an actuator that carries nothing but a joint on the same axis with a spring is the motor of an elastic
    gear. Where no joint has an actuator, all are motors.

    Args:
        model: The compiled model, mujoco.MjModel.
        arm: The arm.
    """
    actuators = [joint_actuator(model, joint.index) for joint in arm.joints]
    driven = any(actuators)
    axes: list[ArmAxis] = []
    motors, k = 0, 0
    while k < len(arm.joints):
        joint, actuator = arm.joints[k], actuators[k]
        is_motor = actuator is not None or not driven
        behind = arm.joints[k + 1] if k + 1 < len(arm.joints) and actuator and actuators[k + 1] is None else None
        deflection = behind if behind is not None and _is_gear(model, joint, behind) else None
        motors += is_motor
        axis = ArmAxis(f"motor_{motors}", len(axes) + 1, joint, deflection, actuator, is_motor)
        if not is_motor:
            axis = ArmAxis(axis.arm_coordinate, axis.number, joint, None, None, False)
        axes.append(axis)
        k += 1 if deflection is None else 2
    return tuple(axes)


def _is_gear(model: Any, joint: ArmJoint, behind: ArmJoint) -> bool:
    """Return whether the second joint is the deflection of an elastic gear behind the first.

    A body of their own between the joints may stand for the rotor: MuJoCo wants some mass there, which counts as none.
    """
    armature = float(model.dof_armature[model.jnt_dofadr[joint.index]])
    return (
        armature > 0
        and joint.mass <= WEIGHTLESS * behind.mass
        and float(np.max(np.abs(joint.inertia))) <= WEIGHTLESS * armature
        and (joint.rotary, joint.axis, joint.sign) == (behind.rotary, behind.axis, behind.sign)
        and float(model.jnt_stiffness[behind.index]) > 0
        and float(np.linalg.norm(joint.anchor - behind.anchor)) < COAXIAL
    )
