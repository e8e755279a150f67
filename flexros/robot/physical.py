"""Checks that the bodies of a robot file are physical."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError

if TYPE_CHECKING:
    from flexros.robot.specification import Body, RobotSpecification
    from flexros.robot.symbolic.chain import Chain, Joint

ROUNDED = 0.01
"""Largest violation of an inequality of the moments of inertia, over the largest moment, that counts as rounding of the
numbers of a file [1] (chosen)."""


def check_physical(specification: RobotSpecification, chain: Chain, source: str) -> None:
    """Refuse non-physical inertias, and motors or tips without inertia.

    A planar chain needs only the inertia about its axis, so the others may be zero (as in Moberg 2007, Table 1).

    Args:
        specification: The robot file.
        chain: Its joints.
        source: File or name; prefix of the error message.

    Raises:
        InputError: Names body and value.
    """
    axes = {joint.axis for joint in chain.joints if joint.rotary}
    for index, body in enumerate(specification.bodies):
        if (
            len(axes) > 1 or chain.turned
        ) and not body.bending:  # the mass points of a link that bends have the rest of its inertia
            _check_tensor(body, f"{source}: body_{index + 1}")
    for joint in chain.joints:
        motor = joint.direction.motor
        if motor and joint.motor_coordinate is not None and motor.inertia.value <= 0:
            raise InputError(
                f"{source}: the motor of {joint.name} has inertia {motor.inertia.value:g}, but a motor behind a "
                "flexible gear needs a positive inertia; give motor.inertia, or declare the spring 'rigid'"
            )
    last = chain.joints[-1]
    if _carried_inertia(specification, last) <= 0:
        raise InputError(
            f"{source}: nothing behind {last.name} has mass or inertia that it moves, so its acceleration is not "
            "determined; give the last body an inertia, or a mass away from the axis, or its motor an inertia"
        )


def _carried_inertia(specification: RobotSpecification, joint: Joint) -> float:
    """Return what the last joint moves, with the motor of a rigid gear: a moment [kg m2], or a mass [kg]."""
    motor, axis = joint.direction.motor, np.eye(3)[joint.axis]
    moved = motor.inertia.value if motor and joint.motor_coordinate is None else 0.0
    origin = np.zeros(3)
    for body in specification.bodies[joint.body :]:
        if joint.rotary:
            arm = np.cross(axis, origin + body.center_of_mass.value)
            moved += body.mass.value * (arm @ arm) + axis @ body.inertia.matrix() @ axis
        else:
            moved += body.mass.value
        origin = origin + body.length.value
    return float(moved)


def _check_tensor(body: Body, place: str) -> None:
    moments = np.linalg.eigvalsh(body.inertia.matrix())
    scale = max(moments[-1], 1e-300)
    if moments[0] < -ROUNDED * scale:
        raise InputError(
            f"{place}: the inertia tensor has the negative principal moment {moments[0]:.6g} kg m2; "
            "all principal moments must be positive; correct inertia"
        )
    if moments[2] > moments[0] + moments[1] + ROUNDED * scale:
        raise InputError(
            f"{place}: the principal moments of inertia {moments[0]:.6g}, {moments[1]:.6g}, {moments[2]:.6g} kg m2 "
            "violate the triangle inequality (the largest exceeds the sum of the others); "
            "correct inertia"
        )
