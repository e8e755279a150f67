"""A point mass added to a link of a URDF, in the frame of that link."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import Rotation

from flexros.errors import InputError
from flexros.robot.exchange.number_text import number
from flexros.robot.point_inertia import point_inertia

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.robot.exchange.numbers import LoadNumbers
    from flexros.robot.exchange.xml_text import XmlElement

_ENTRIES = {"ixx": (0, 0), "iyy": (1, 1), "izz": (2, 2), "ixy": (0, 1), "ixz": (0, 2), "iyz": (1, 2)}


def add_load(
    root: XmlElement, link: XmlElement, load: LoadNumbers, source: str, turn: FloatArray
) -> tuple[float, float]:
    """Write mass, centre of mass and inertia of a link with a point mass on it.

    Args:
        root: The URDF.
        link: The link, which has a mass.
        load: The point mass; its place is in the frame of its body.
        source: The file, for error messages.
        turn: Rotation from that frame to the base of the URDF with all joints at zero, shape (3, 3).

    Returns:
        Mass before and after [kg].

    Raises:
        InputError: A number of the link is none.
    """
    inertial = link.find("inertial")
    assert inertial is not None
    mass, origin, inertia = (inertial.find(tag) for tag in ("mass", "origin", "inertia"))
    assert mass is not None
    place = f"{source}: link {link.attributes['name']}"
    own = _numbers(mass, "value", 1, place)[0]
    center = _numbers(origin, "xyz", 3, place)
    own_turn = Rotation.from_euler("xyz", _numbers(origin, "rpy", 3, place)).as_matrix()
    J = np.zeros((3, 3))
    for name, (row, column) in _ENTRIES.items():
        J[row, column] = J[column, row] = _numbers(inertia, name, 1, place)[0]
    at = _rotation(root, link.attributes["name"], source).T @ turn @ np.array(load.place)
    whole = own + load.mass
    common = (own * center + load.mass * at) / whole
    J = own_turn @ J @ own_turn.T + point_inertia(own, center - common) + point_inertia(load.mass, at - common)
    mass.set("value", number(whole))
    texts = {"xyz": " ".join(map(number, common.tolist())), "rpy": "0 0 0"}
    entries = {name: number(float(J[index])) for name, index in _ENTRIES.items()}
    for tag, element, values in (("origin", origin, texts), ("inertia", inertia, entries)):
        if element is None:
            inertial.add(tag, values)
            continue
        for name, text in values.items():
            element.set(name, text)
    return own, whole


def _rotation(root: XmlElement, link: str, source: str) -> FloatArray:
    """Return the rotation from the frame of a link to that of the base with all joints at zero, shape (3, 3)."""
    above = {joint.find("child").attributes.get("link"): joint for joint in root.children if _is_joint(joint)}  # type: ignore[union-attr]
    turn, here = np.eye(3), link
    for _ in range(len(above)):
        joint = above.get(here)
        if joint is None:
            break
        angles = _numbers(joint.find("origin"), "rpy", 3, f"{source}: joint {joint.attributes.get('name', '')}")
        turn = Rotation.from_euler("xyz", angles).as_matrix() @ turn
        here = joint.find("parent").attributes.get("link", "")  # type: ignore[union-attr]
    return np.asarray(turn)


def _is_joint(element: XmlElement) -> bool:
    return element.tag == "joint" and element.find("child") is not None and element.find("parent") is not None


def _numbers(element: XmlElement | None, name: str, count: int, place: str) -> FloatArray:
    """Read numbers of an attribute, zeros where it is missing, shape (count,)."""
    text = "" if element is None else element.attributes.get(name, "")
    if not text.strip():
        return np.zeros(count)
    try:
        values = np.array([float(part) for part in text.split()])
    except ValueError:
        values = np.zeros(0)
    if len(values) != count:
        raise InputError(f"{place}: {name} is '{text}', but must be {count} numbers; correct the file", "base")
    return values
