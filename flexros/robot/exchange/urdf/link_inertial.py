"""Mass, centre of mass and inertia of a link of a URDF, in the frame of that link."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import Rotation

from flexros.errors import InputError
from flexros.robot.exchange import body_inertia
from flexros.robot.exchange.body_inertia import BodyInertia
from flexros.robot.exchange.number_text import number, numbers_text
from flexros.robot.exchange.numbers import SAME, Written

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.robot.exchange.xml_text import XmlElement

ROUNDED = 1e-12
"""Number of a link up to which it is zero but for round-off [m, kg m2] (chosen)."""
ENTRIES = {f"i{entry}": at for entry, at in body_inertia.ENTRIES.items()}
"""Attributes of <inertia>, and their places in the tensor."""


def link_inertia(link: XmlElement, source: str) -> BodyInertia:
    """Read mass, centre of mass and inertia of a link that has a mass, in its frame.

    Args:
        link: The link.
        source: The file, for error messages.

    Raises:
        InputError: A number of the link is none.
    """
    mass, origin, inertia = _elements(link)
    place = f"{source}: link {link.attributes['name']}"
    turn = Rotation.from_euler("xyz", _numbers(origin, "rpy", 3, place)).as_matrix()
    J = np.zeros((3, 3))
    for name, (row, column) in ENTRIES.items():
        J[row, column] = J[column, row] = _numbers(inertia, name, 1, place)[0]
    return BodyInertia(
        float(_numbers(mass, "value", 1, place)[0]), _numbers(origin, "xyz", 3, place), turn @ J @ turn.T
    )


def write_link_inertia(link: XmlElement, numbers: BodyInertia) -> None:
    """Write mass, centre of mass and inertia of a link that has a mass, along the axes of its frame.

    Args:
        link: The link.
        numbers: Its numbers, in its frame.
    """
    mass, origin, inertia = _elements(link)
    mass.set("value", number(numbers.mass))
    texts = {"xyz": numbers_text(numbers.center), "rpy": "0 0 0"}
    entries = {name: number(float(numbers.inertia[index])) for name, index in ENTRIES.items()}
    for tag, element, values in (("origin", origin, texts), ("inertia", inertia, entries)):
        if element is None:
            link.find("inertial").add(tag, values)  # type: ignore[union-attr]
            continue
        for name, text in values.items():
            element.set(name, text)


def changes_of_link(body: str, link: str, before: BodyInertia, after: BodyInertia) -> list[Written]:
    """List the numbers of a link that were changed.

    Args:
        body: The body of the robot that it is.
        link: Name of the link.
        before: Its numbers before, in its frame.
        after: Its numbers now.
    """
    entries = [("mass", "inertial mass", before.mass, after.mass, "kg")]
    entries += [
        (f"centre of mass {axis}", "inertial origin xyz", float(old), float(new), "m")
        for axis, old, new in zip("xyz", before.center, after.center, strict=True)
    ]
    entries += [
        ("inertia", f"inertial {name}", float(before.inertia[at]), float(after.inertia[at]), "kg m2")
        for name, at in ENTRIES.items()
    ]
    return [
        Written(body, quantity, f"link {link} {place}", old, new, unit)
        for quantity, place, old, new, unit in entries
        if not np.isclose(old, new, rtol=SAME, atol=ROUNDED)
    ]


def link_axes(root: XmlElement, link: str, source: str, turn: FloatArray) -> FloatArray:
    """Return the rotation from the frame of a body to that of its link, shape (3, 3).

    Args:
        root: The URDF.
        link: Name of the link.
        source: The file, for error messages.
        turn: Rotation from the frame of the body to the base of the URDF with all joints at zero, shape (3, 3).

    Raises:
        InputError: An angle of a joint is no number.
    """
    return np.asarray(_rotation(root, link, source).T @ turn)


def _elements(link: XmlElement) -> tuple[XmlElement, XmlElement | None, XmlElement | None]:
    inertial = link.find("inertial")
    assert inertial is not None
    mass, origin, inertia = (inertial.find(tag) for tag in ("mass", "origin", "inertia"))
    assert mass is not None
    return mass, origin, inertia


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
