"""Checks that the bodies of a robot file are physical."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError

if TYPE_CHECKING:
    from flexros.robot.specification import Body, RobotSpecification
    from flexros.robot.symbolic.chain import Chain


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
        if len(axes) > 1 and not body.bending:  # the mass points of a link that bends have the rest of its inertia
            _check_tensor(body, f"{source}: body_{index + 1}")
    for joint in chain.joints:
        motor = joint.direction.motor
        if motor and joint.motor_coordinate is not None and motor.inertia.value <= 0:
            raise InputError(
                f"{source}: the motor of {joint.name} has inertia {motor.inertia.value:g}, but a motor behind a "
                "flexible gear needs a positive inertia; give motor.inertia, or declare the spring 'rigid'"
            )
    last = chain.joints[-1]
    carried = specification.bodies[last.body :]
    if not any(body.mass.value > 0 or np.any(body.inertia.matrix()) for body in carried):
        raise InputError(
            f"{source}: nothing behind {last.name} has mass or inertia, so its acceleration is not determined; "
            "give the last body a mass or an inertia"
        )


def _check_tensor(body: Body, place: str) -> None:
    moments = np.linalg.eigvalsh(body.inertia.matrix())
    scale = max(moments[-1], 1e-300)
    if moments[0] < -1e-9 * scale:
        raise InputError(
            f"{place}: the inertia tensor has the negative principal moment {moments[0]:.6g} kg m2; "
            "all principal moments must be positive; correct inertia"
        )
    if moments[2] > moments[0] + moments[1] + 1e-9 * scale:
        raise InputError(
            f"{place}: the principal moments of inertia {moments[0]:.6g}, {moments[1]:.6g}, {moments[2]:.6g} kg m2 "
            "violate the triangle inequality (the largest exceeds the sum of the others); "
            "correct inertia"
        )
