"""Export of a robot as an SDF model for Gazebo."""

from __future__ import annotations

from typing import TYPE_CHECKING
from xml.etree import ElementTree

import numpy as np

from flexros.robot.exchange.link_inertia import LEAST, possible_tensor
from flexros.robot.exchange.number_text import number
from flexros.robot.exchange.urdf.export import urdf_text

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

    from flexros.arrays import FloatArray
    from flexros.robot import Robot

VERSION = "1.9"
"""Version of the format: frames are named by `relative_to`, a continuous joint has its own type."""

ENTRIES = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2), "izz": (2, 2)}
"""Row and column of the entries of a tensor."""


def sdf_text(robot: Robot) -> str:
    """Return the SDF model of a robot with stiff gears and links, from its URDF: the same links and joints.

    The first link is fixed to the world. Links without mass get a very small one, because Gazebo gives them 1 kg.

    Args:
        robot: The robot, with values on the arm side.
    """
    urdf = ElementTree.fromstring(urdf_text(robot))  # noqa: S314 - own text
    root = ElementTree.Element("sdf", version=VERSION)
    model = ElementTree.SubElement(root, "model", name=robot.name)
    joints = {_name(joint, "child", "link"): joint for joint in urdf.findall("joint")}
    for link in urdf.findall("link"):
        _link(model, robot, link, joints.get(link.get("name", "")))
    first = urdf.findall("link")[0].get("name", "")
    fixed = ElementTree.SubElement(model, "joint", name="world_fixed", type="fixed")
    ElementTree.SubElement(fixed, "parent").text = "world"
    ElementTree.SubElement(fixed, "child").text = first
    for joint in urdf.findall("joint"):
        _joint(model, joint)
    ElementTree.indent(root)
    return f'<?xml version="1.0"?>\n{ElementTree.tostring(root, encoding="unicode")}\n'


def _matrix(inertia: Element | None) -> FloatArray:
    tensor = np.zeros((3, 3))
    for key, (row, column) in ENTRIES.items() if inertia is not None else ():
        assert inertia is not None
        tensor[row, column] = tensor[column, row] = float(inertia.get(key, "0"))
    return tensor


def _name(element: Element, tag: str, key: str) -> str:
    found = element.find(tag)
    return "" if found is None else found.get(key, "")


def _pose(element: Element | None) -> str:
    if element is None:
        return "0 0 0 0 0 0"
    return f"{element.get('xyz', '0 0 0')} {element.get('rpy', '0 0 0')}"


def _link(model: Element, robot: Robot, link: Element, joint: Element | None) -> None:
    made = ElementTree.SubElement(model, "link", name=link.get("name", ""))
    if joint is not None:
        ElementTree.SubElement(made, "pose", relative_to=joint.get("name", "")).text = "0 0 0 0 0 0"
    inertial = link.find("inertial")
    own = ElementTree.SubElement(made, "inertial")
    ElementTree.SubElement(own, "pose").text = _pose(None if inertial is None else inertial.find("origin"))
    mass = 0.0 if inertial is None else float(_name(inertial, "mass", "value"))
    ElementTree.SubElement(own, "mass").text = number(max(mass, LEAST))
    tensor, given = ElementTree.SubElement(own, "inertia"), None if inertial is None else inertial.find("inertia")
    full = possible_tensor(robot, _matrix(given))
    for key, (row, column) in ENTRIES.items():
        ElementTree.SubElement(tensor, key).text = number(full[row, column])
    visual = link.find("visual")
    if visual is not None:
        shown = ElementTree.SubElement(made, "visual", name="shape")
        ElementTree.SubElement(shown, "pose").text = _pose(visual.find("origin"))
        cylinder = ElementTree.SubElement(ElementTree.SubElement(shown, "geometry"), "cylinder")
        for key, value in ((k, v) for each in visual.iter("cylinder") for k, v in each.attrib.items()):
            ElementTree.SubElement(cylinder, key).text = value


def _joint(model: Element, joint: Element) -> None:
    made = ElementTree.SubElement(model, "joint", name=joint.get("name", ""), type=joint.get("type", ""))
    parent = _name(joint, "parent", "link")
    ElementTree.SubElement(made, "pose", relative_to=parent).text = _pose(joint.find("origin"))
    ElementTree.SubElement(made, "parent").text = parent
    ElementTree.SubElement(made, "child").text = _name(joint, "child", "link")
    if joint.get("type") == "fixed":
        return
    axis = ElementTree.SubElement(made, "axis")
    ElementTree.SubElement(axis, "xyz").text = _name(joint, "axis", "xyz")
    for tag in ("limit", "dynamics"):
        given = joint.find(tag)
        if given is not None:
            inner = ElementTree.SubElement(axis, tag)
            for key, value in given.attrib.items():
                ElementTree.SubElement(inner, key).text = value
