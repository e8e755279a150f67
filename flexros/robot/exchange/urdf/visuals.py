"""Shapes of a URDF: what is drawn of each body of a robot file that was made from it."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np
from scipy.spatial.transform import Rotation

from flexros.config.text_file import read_text
from flexros.errors import InputError
from flexros.input_limits import LARGEST_URDF
from flexros.robot.body_placement import BodyPlacements
from flexros.robot.exchange.urdf.robot_import import turned_base
from flexros.robot.exchange.urdf.tree import read_numbers, read_tree

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from xml.etree import ElementTree

    from flexros.arrays import FloatArray
    from flexros.robot import Robot

Kind = Literal["box", "cylinder", "sphere", "mesh"]
SIZES: dict[str, tuple[tuple[str, int], ...]] = {
    "box": (("size", 3),),
    "cylinder": (("radius", 1), ("length", 1)),
    "sphere": (("radius", 1),),
}
"""Attributes of each shape in order, with the number of values."""
BASE = -1
"""Index that stands for the base in place of a body."""


@dataclass(frozen=True, eq=False)
class Visual:
    """A shape that is fixed to a body.

    Attributes:
        body: Index of the body; -1 for the base.
        link: Name of its link in the URDF.
        kind: "box", "cylinder" (along its z axis, about its centre), "sphere" or "mesh".
        size: Edges of a box, radius and length of a cylinder, radius of a sphere, scale of a mesh [m or 1].
        file: Name of the mesh as in the URDF; empty for the others.
        rotation: Its frame in that of the body, shape (3, 3).
        origin: Its origin in the frame of the body [m], shape (3,).
    """

    body: int
    link: str
    kind: Kind
    size: tuple[float, ...]
    file: str
    rotation: FloatArray
    origin: FloatArray


def visuals(robot: Robot) -> list[Visual]:
    """Return the shapes of the URDF that a robot file names as its drawing.

    Args:
        robot: The robot; the labels of its bodies name the links.

    Returns:
        All shapes on the links of the arm, of what they carry, and of the base; none without a drawing.

    Raises:
        InputError: The URDF cannot be read, or its chain is not that of the bodies.
    """
    file = robot.spec.drawing
    if not file:
        return []
    tree = read_tree(read_text(Path(file), "URDF", LARGEST_URDF), file)
    labels = [body.label for body in robot.spec.bodies]
    chain = tree.chain(labels[-1])
    if [joint.child for joint in chain] != labels:
        raise InputError(
            f"{file}: the links up to '{labels[-1]}' are {', '.join(joint.child for joint in chain)}, but the bodies "
            f"of {robot.name} have the labels {', '.join(labels)}; correct the labels, or the key drawing"
        )
    inside = {joint.name for joint in chain}
    base = turned_base(chain)
    _, at_zero = BodyPlacements(robot).at(np.zeros((1, robot.n_arm)))
    found = _of_links(tree.fixed_to(chain[0].parent, inside), tree.links, BASE, base, -base @ chain[0].origin, file)
    rotation = base
    for body, joint in enumerate(chain):
        rotation = rotation @ joint.rotation
        links = tree.fixed_to(joint.child, inside)
        found += _of_links(links, tree.links, body, at_zero[0, body].T @ rotation, np.zeros(3), file)
    return found


def mesh_path(name: str, urdf: Path) -> Path | None:
    """Return the file of a mesh; None where it is not found.

    `package://PACKAGE/...` is looked for above the URDF, in `ROS_PACKAGE_PATH` and in `share` of `AMENT_PREFIX_PATH`.

    Args:
        name: Name of the mesh as in the URDF.
        urdf: The URDF.
    """
    scheme, separator, rest = name.partition("://")
    if not separator:
        places = [urdf.parent / name]
    elif scheme == "file":
        places = [Path(rest)]
    else:
        package, _, inside = rest.partition("/")
        above = [folder for folder in urdf.absolute().parents if folder.name == package]
        roots = [*urdf.absolute().parents]
        roots += [Path(root) for root in os.environ.get("ROS_PACKAGE_PATH", "").split(":") if root]
        roots += [Path(root) / "share" for root in os.environ.get("AMENT_PREFIX_PATH", "").split(":") if root]
        places = [*(folder / inside for folder in above), *(root / package / inside for root in roots)]
    return next((place for place in places if place.is_file()), None)


def _of_links(
    links: list[tuple[str, FloatArray, FloatArray]],
    elements: Mapping[str, ElementTree.Element],
    body: int,
    rotation: FloatArray,
    origin: FloatArray,
    file: str,
) -> list[Visual]:
    """Return the shapes of links that are fixed to a body, whose first link has a pose in the body."""
    return [
        Visual(body, name, kind, size, mesh, rotation @ turn @ own_turn, origin + rotation @ (place + turn @ own_place))
        for name, turn, place in links
        for kind, size, mesh, own_turn, own_place in _of_link(elements[name], f"{file}: link '{name}'")
    ]


def _of_link(
    link: ElementTree.Element, place: str
) -> Iterator[tuple[Kind, tuple[float, ...], str, FloatArray, FloatArray]]:
    """Yield kind, size, mesh, rotation and origin of each shape of a link, in its frame."""
    for visual in link.findall("visual"):
        origin = visual.find("origin")
        turn = Rotation.from_euler("xyz", read_numbers(origin, "rpy", "0 0 0", 3, place)).as_matrix()
        at = read_numbers(origin, "xyz", "0 0 0", 3, place)
        for shape in visual.findall("geometry/*"):
            if shape.tag == "mesh":
                scale = read_numbers(shape, "scale", "1 1 1", 3, place)
                yield "mesh", tuple(scale.tolist()), shape.get("filename", ""), turn, at
            elif shape.tag in SIZES:
                numbers = [read_numbers(shape, key, "", count, place) for key, count in SIZES[shape.tag]]
                yield shape.tag, tuple(np.concatenate(numbers).tolist()), "", turn, at  # type: ignore[misc]
