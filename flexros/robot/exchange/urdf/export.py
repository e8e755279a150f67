"""Export of a robot as a URDF, for robot_description in ROS."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal
from xml.etree import ElementTree

import numpy as np

from flexros.robot.exchange.number_text import number, numbers_text
from flexros.robot.exchange.urdf.tree import NO_LIMIT
from flexros.robot.link_shape import link_shapes, tool_offset

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

    from flexros.arrays import FloatArray
    from flexros.robot import Robot
    from flexros.robot.link_shape import LinkShape
    from flexros.robot.specification import Body
    from flexros.robot.symbolic.chain import Joint

Flexible = Literal["fixed", "continuous"]
"""Representation of elastic directions and gears: stiff, or as joints."""

FLEXIBLE: tuple[Flexible, ...] = ("fixed", "continuous")

BASE_LINK = "base"
TOOL_LINK = "tool"


def urdf_text(robot: Robot, flexible: Flexible = "fixed") -> str:
    """Return the URDF of a robot.

    Links are `base`, `body_1`, `body_2`, ... and `tool`; at zero all frames are parallel to the base, or turned as the
    robot file says. Motors are the joints `motor_1`, `motor_2`, ..., as in the topic joint_states. Elastic directions
    are joints with the names of the arm coordinates. With "continuous" a flexible gear is also a joint, behind its
    motor: the joint `body_1.ry` is then the deflection of the gear, arm angle minus motor angle. Rotor inertias are
    omitted: a URDF has no gears.

    Args:
        robot: The robot.
        flexible: "fixed": springs are rigid, only the motors move; "continuous": each spring is a joint.
    """
    root = ElementTree.Element("robot", name=robot.name)
    ElementTree.SubElement(root, "link", name=BASE_LINK)
    shapes = {shape.body: shape for shape in link_shapes(robot.spec)}
    parent, offset = BASE_LINK, np.zeros(3)
    for index, body in enumerate(robot.spec.bodies):
        joints = [joint for joint in robot.joints if joint.body == index and joint.mode is None]  # links are straight
        for joint in joints:
            child = f"body_{index + 1}" if joint.last else f"body_{index + 1}_{joint.name.split('.')[1]}"
            parent = _add_joint(root, joint, flexible, parent, child, offset)
            offset = np.zeros(3)
        if joints:
            link = root.findall("link")[-1]
        else:
            link = _add_fixed(root, f"body_{index + 1}.fixed", parent, f"body_{index + 1}", offset)
            parent = f"body_{index + 1}"
        _describe(link, body, shapes.get(index))
        offset = np.array(body.length.value, dtype=float)
    if robot.spec.tool.linear is None:
        _add_fixed(root, "tool.fixed", parent, TOOL_LINK, tool_offset(robot.spec))
    ElementTree.indent(root)
    return f'<?xml version="1.0"?>\n{ElementTree.tostring(root, encoding="unicode")}\n'


def _add_joint(root: Element, joint: Joint, flexible: Flexible, parent: str, child: str, offset: FloatArray) -> str:
    """Add the joints of a direction, of motor and spring; return the new last link."""
    moves = {True: "continuous", False: "prismatic"}[joint.rotary]
    springs = moves if flexible == "continuous" else "fixed"
    if joint.motor is None:
        _connect(root, joint, joint.name, springs, parent, child, offset)
        return child
    name = f"motor_{joint.motor + 1}"
    if joint.motor_coordinate is None or flexible == "fixed":
        _connect(root, joint, name, moves, parent, child, offset)
        return child
    rotor = f"{name}_rotor"
    _connect(root, joint, name, moves, parent, rotor, offset)
    _connect(root, joint, joint.name, springs, rotor, child, np.zeros(3))
    return child


def _connect(root: Element, joint: Joint, name: str, kind: str, parent: str, child: str, offset: FloatArray) -> None:
    # the joint of the spring behind a motor is in the frame of the rotor, which is turned already
    turned = joint.orientation if joint.motor is None or name != joint.name else (0.0, 0.0, 0.0)
    element = _joint(root, name, kind, parent, child, offset, turned)
    ElementTree.SubElement(root, "link", name=child)
    if kind == "fixed":
        return
    axis = np.zeros(3)
    axis[joint.axis] = 1
    ElementTree.SubElement(element, "axis", xyz=numbers_text(axis))
    is_motor = name != joint.name
    motor = joint.direction.motor if is_motor else None
    torque, speed = (motor.torque_limit, motor.speed_limit) if motor else (None, None)
    limit = {key: NO_LIMIT if each is None else each.value for key, each in (("effort", torque), ("velocity", speed))}
    if kind == "prismatic":
        limit |= {"lower": -NO_LIMIT, "upper": NO_LIMIT}
    ElementTree.SubElement(element, "limit", {key: number(value) for key, value in limit.items()})
    damping = motor.viscous_friction if motor else joint.direction.damper
    ElementTree.SubElement(element, "dynamics", damping=number(damping.value))


def _add_fixed(root: Element, name: str, parent: str, child: str, offset: FloatArray) -> Element:
    _joint(root, name, "fixed", parent, child, offset)
    return ElementTree.SubElement(root, "link", name=child)


def _joint(
    root: Element,
    name: str,
    kind: str,
    parent: str,
    child: str,
    offset: FloatArray,
    turned: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> Element:
    element = ElementTree.SubElement(root, "joint", name=name, type=kind)
    origin = ElementTree.SubElement(element, "origin", xyz=numbers_text(offset))
    if any(turned):
        origin.set("rpy", numbers_text(turned))
    ElementTree.SubElement(element, "parent", link=parent)
    ElementTree.SubElement(element, "child", link=child)
    return element


def _describe(link: Element, body: Body, shape: LinkShape | None) -> None:
    """Add mass, centre of mass, inertia and the displayed bar of a body."""
    inertial = ElementTree.SubElement(link, "inertial")
    ElementTree.SubElement(inertial, "origin", xyz=numbers_text(body.center_of_mass.value))
    ElementTree.SubElement(inertial, "mass", value=number(body.mass.value))
    tensor, axes = body.straight_inertia(), ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
    entries = {f"i{'xyz'[i]}{'xyz'[j]}": float(tensor[i, j]) for i, j in axes}
    ElementTree.SubElement(inertial, "inertia", {key: number(value) for key, value in entries.items()})
    if shape is None:
        return
    visual = ElementTree.SubElement(link, "visual")
    along = shape.end - shape.start
    roll_pitch_yaw = (
        0.0,
        float(np.arctan2(np.hypot(along[0], along[1]), along[2])),
        float(np.arctan2(along[1], along[0])),
    )
    middle = (shape.start + shape.end) / 2
    ElementTree.SubElement(visual, "origin", xyz=numbers_text(middle), rpy=numbers_text(roll_pitch_yaw))
    geometry = ElementTree.SubElement(visual, "geometry")
    length = float(np.linalg.norm(along))
    ElementTree.SubElement(geometry, "cylinder", radius=number(shape.radius), length=number(length))
