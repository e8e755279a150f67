"""Oracle: the bodies of a robot as a Pinocchio model."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

if TYPE_CHECKING:
    from flexros.robot import Robot

JOINTS = {
    "rx": pin.JointModelRX,
    "ry": pin.JointModelRY,
    "rz": pin.JointModelRZ,
    "tx": pin.JointModelPX,
    "ty": pin.JointModelPY,
    "tz": pin.JointModelPZ,
}


def build(robot: Robot) -> pin.Model:
    """Build the chain; frame "tool" is the tool point of robots without a linear tool coordinate."""
    model = pin.Model()
    model.gravity = pin.Motion(np.array(robot.spec.gravity.value), np.zeros(3))
    parent, placement = 0, pin.SE3.Identity()
    for index, body in enumerate(robot.spec.bodies):
        for axis in body.directions:
            name = f"body_{index + 1}.{axis}"
            if name in robot.arm_names:
                parent = model.addJoint(parent, JOINTS[axis](), placement, name)
                placement = pin.SE3.Identity()
        inertia = pin.Inertia(body.mass.value, np.array(body.center_of_mass.value), body.inertia.matrix())
        model.appendBodyToJoint(parent, inertia, placement)
        placement = placement * pin.SE3(np.eye(3), np.array(body.length.value))
    model.addFrame(pin.Frame("tool", parent, placement, pin.FrameType.OP_FRAME))
    return model
