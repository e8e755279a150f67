"""Skeleton of a robot file from a URDF: geometry and inertia are imported, springs are left to the user."""

from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import PurePath
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree

import numpy as np
from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap, CommentedSeq
from scipy.spatial.transform import Rotation

from flexros.config.text_file import read_text
from flexros.errors import InputError
from flexros.input_limits import LARGEST_URDF
from flexros.robot.quantity import unit_of

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from flexros.arrays import FloatArray

MOVABLE = ("revolute", "continuous", "prismatic")


@dataclass(frozen=True)
class _Joint:
    name: str
    kind: str
    parent: str
    child: str
    origin: FloatArray
    rotation: FloatArray
    axis: FloatArray
    effort: float
    damping: float
    friction: float


def skeleton_from_urdf(file: Path) -> str:
    """Return the text of a robot file (YAML) from a URDF with one serial chain; see `skeleton_from_text`.

    Args:
        file: The URDF.

    Raises:
        InputError: The file cannot be read, or as in `skeleton_from_text`.
    """
    return skeleton_from_text(read_text(file, "URDF", LARGEST_URDF), str(file))


def skeleton_from_text(text: str, file: str) -> str:
    """Return the text of a robot file (YAML) from that of a URDF with one serial chain.

    All frames of a robot file are parallel to the base at zero; the URDF's inertias are rotated accordingly. Every
    gear is initially rigid: the user replaces the word by a stiffness, and adds elastic directions. The tags
    `motor_1.joint`, ... name the joints, `motor_1.joint_sign`, ... are -1 where a joint turns the other way.

    Args:
        text: The URDF.
        file: Where it comes from: a file or a topic.

    Raises:
        InputError: Not a URDF, invalid numbers, a chain that branches or closes, or a joint axis that is not along
            a coordinate axis at zero.
    """
    root = _parse(text, file)
    links = {link.get("name", ""): link for link in root.findall("link")}
    joints = _chain(root, links, file)
    bodies = CommentedSeq()
    outputs: list[str] = []
    tags: dict[str, str] = {}
    rotation = np.eye(3)
    length_before = np.zeros(3)
    for joint in joints:
        offset = rotation @ joint.origin
        if bodies:
            bodies[-1]["length"] = _numbers(offset)
        else:
            length_before = offset
        rotation = rotation @ joint.rotation
        body = _body(links[joint.child], rotation, file)
        if joint.kind in MOVABLE:
            axis = _base_axis(joint, rotation, file)
            index = int(np.argmax(np.abs(axis)))
            direction = ("t" if joint.kind == "prismatic" else "r") + "xyz"[index]
            body["directions"] = CommentedMap({direction: _gear(joint, opposite=bool(axis[index] < 0))})
            outputs.append(f"body_{len(bodies) + 1}.{direction}")
            tags[f"motor_{len(outputs)}.joint"] = joint.name
            if axis[index] < 0:
                tags[f"motor_{len(outputs)}.joint_sign"] = "-1"
        bodies.append(body)
    if not outputs:
        raise InputError(f"{file}: no revolute, continuous or prismatic joint was found; give the URDF of a robot arm")
    path = PurePath(file)
    return _text(root.get("name", path.stem), path.name, bodies, outputs, tags, length_before)


def _parse(text: str, file: str) -> ElementTree.Element:
    if "<!ENTITY" in text or "<!DOCTYPE" in text:
        raise InputError(f"{file} has a document type definition, which a URDF does not need; remove it")
    try:
        root = ElementTree.fromstring(text)  # noqa: S314 - entities are refused above
    except ElementTree.ParseError as error:
        raise InputError(f"{file} is not XML ({error}); give a URDF file (run xacro first)") from error
    if root.tag != "robot":
        raise InputError(f"{file} starts with <{root.tag}>, but a URDF starts with <robot>; give a URDF file")
    return root


def _read(element: ElementTree.Element | None, key: str, default: str, count: int, place: str) -> FloatArray:
    """Read an attribute as finite numbers, shape (count,), with a default."""
    text = default if element is None else element.get(key, default)
    try:
        numbers = np.array([float(part) for part in text.split()])
    except ValueError:
        numbers = np.zeros(0)
    if element is not None and (numbers.shape != (count,) or not np.all(np.isfinite(numbers))):
        wanted = "a finite number" if count == 1 else f"{count} finite numbers"
        raise InputError(f"{place}: {key} of <{element.tag}> is '{text}', but must be {wanted}; correct the URDF")
    return numbers


def _vector(element: ElementTree.Element | None, key: str, default: str, place: str) -> FloatArray:
    return _read(element, key, default, 3, place)


def _scalar(element: ElementTree.Element | None, key: str, place: str) -> float:
    return float(_read(element, key, "0", 1, place)[0])


def _joint(element: ElementTree.Element, links: Mapping[str, ElementTree.Element], file: str) -> _Joint:
    place = f"{file}: joint '{element.get('name')}'"
    ends: dict[str, str] = {}
    for end in ("parent", "child"):
        found = element.find(end)
        if found is None:
            raise InputError(f"{place} lacks <{end}>; correct the URDF")
        ends[end] = found.get("link", "")
        if ends[end] not in links:
            raise InputError(
                f"{place} names the {end} link '{ends[end]}', but the links are {', '.join(links)}; correct the URDF"
            )
    origin = element.find("origin")
    return _Joint(
        name=element.get("name", ""),
        kind=element.get("type", "fixed"),
        parent=ends["parent"],
        child=ends["child"],
        origin=_vector(origin, "xyz", "0 0 0", place),
        rotation=Rotation.from_euler("xyz", _vector(origin, "rpy", "0 0 0", place)).as_matrix(),
        axis=_vector(element.find("axis"), "xyz", "1 0 0", place),
        effort=_scalar(element.find("limit"), "effort", place),
        damping=_scalar(element.find("dynamics"), "damping", place),
        friction=_scalar(element.find("dynamics"), "friction", place),
    )


def _refuse_loops(joints: Sequence[_Joint], file: str) -> None:
    """Refuse links with two parents and closed chains: the joints must form a tree."""
    above: dict[str, _Joint] = {}
    for joint in joints:
        if joint.child in above:
            raise InputError(
                f"{file}: joints '{above[joint.child].name}' and '{joint.name}' both carry the link '{joint.child}', "
                "but each link of a URDF has one parent; remove one of them"
            )
        above[joint.child] = joint
    clear: set[str] = set()
    for start in above:
        here, way = start, set[str]()
        while here in above and here not in clear:
            if here in way:
                raise InputError(
                    f"{file}: joint '{above[here].name}' closes a circle of joints through the link '{here}', but a "
                    "URDF is a tree and a robot here one serial chain; remove a joint of the circle"
                )
            way.add(here)
            here = above[here].parent
        clear |= way


def _chain(root: ElementTree.Element, links: Mapping[str, ElementTree.Element], file: str) -> list[_Joint]:
    """Follow the joints from the base link; side branches without movable joints (tool frames) are omitted."""
    joints = [_joint(element, links, file) for element in root.findall("joint")]
    _refuse_loops(joints, file)
    children: dict[str, list[_Joint]] = {}
    for joint in joints:
        children.setdefault(joint.parent, []).append(joint)
    carried = {joint.child for joint in joints}
    bases = [name for name in links if name not in carried]
    chain: list[_Joint] = []
    here = bases[0] if bases else ""
    while children.get(here):
        moving = [joint for joint in children[here] if _movable_below(joint, children)]
        if len(moving) > 1:
            names = ", ".join(joint.name for joint in moving)
            raise InputError(f"{file}: link '{here}' carries the chains {names}, but a robot here is one serial chain")
        following = moving or (children[here] if len(children[here]) == 1 else [])
        if not following:
            break
        chain.append(following[0])
        here = following[0].child
    return chain


def _movable_below(joint: _Joint, children: dict[str, list[_Joint]]) -> bool:
    waiting = [joint]
    while waiting:  # no recursion: a chain may exceed Python's stack
        here = waiting.pop()
        if here.kind in MOVABLE:
            return True
        waiting += children.get(here.child, [])
    return False


def _base_axis(joint: _Joint, rotation: FloatArray, file: str) -> FloatArray:
    """Return the axis of a joint at zero in the base frame, along a coordinate axis, shape (3,)."""
    length = float(np.linalg.norm(joint.axis))
    if not length > 0:
        raise InputError(
            f"{file}: joint '{joint.name}' has the axis {joint.axis.tolist()}, which has no direction; correct the URDF"
        )
    axis: FloatArray = rotation @ (joint.axis / length)
    if np.max(np.abs(axis)) < 1 - 1e-6:
        raise InputError(
            f"{file}: joint '{joint.name}' turns about {np.round(axis, 4).tolist()} at zero, but axes must lie "
            "along x, y or z of the base; turn the base frame or the zero pose"
        )
    return axis


def _gear(joint: _Joint, opposite: bool) -> CommentedMap:
    motor = CommentedMap({"inertia": 0, "viscous_friction": _number(max(joint.damping, 0.0)) or 0})
    if joint.effort > 0:
        motor["torque_limit"] = joint.effort
    motor.fa.set_flow_style()
    gear = CommentedMap({"spring": "rigid", "damper": 0, "motor": motor})
    unit = unit_of("stiffness", joint.kind != "prismatic")
    gear.yaml_add_eol_comment(f"replace by the gear's stiffness [{unit}]; then give damper and motor inertia", "spring")
    notes = ["the URDF's axis points the other way: its joint angle has the opposite sign"] if opposite else []
    if joint.friction > 0:
        notes.append(
            f"the URDF's dry friction of {joint.friction:g} is no part of a robot file: effect coulomb_friction"
        )
    if notes:
        gear.yaml_set_start_comment("\n".join(notes))
    return gear


def _body(link: ElementTree.Element, rotation: FloatArray, file: str) -> CommentedMap:
    body = CommentedMap({"label": link.get("name", "")})
    place = f"{file}: link '{link.get('name', '')}'"
    inertial = link.find("inertial")
    if inertial is None:
        return body
    mass, tensor, origin = inertial.find("mass"), inertial.find("inertia"), inertial.find("origin")
    body["mass"] = _scalar(mass, "value", place)
    body["center_of_mass"] = _numbers(rotation @ _vector(origin, "xyz", "0 0 0", place))
    if tensor is not None:
        entries = {key: _scalar(tensor, f"i{key}", place) for key in ("xx", "yy", "zz", "xy", "xz", "yz")}
        J = np.array(
            [
                [entries["xx"], entries["xy"], entries["xz"]],
                [entries["xy"], entries["yy"], entries["yz"]],
                [entries["xz"], entries["yz"], entries["zz"]],
            ]
        )
        turn = rotation @ Rotation.from_euler("xyz", _vector(origin, "rpy", "0 0 0", place)).as_matrix()
        J = turn @ J @ turn.T
        pairs = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
        inertia = CommentedMap({key: _number(J[place]) for key, place in pairs.items() if abs(J[place]) > 1e-12})
        inertia.fa.set_flow_style()
        body["inertia"] = inertia
    return body


def _number(value: float) -> float:
    rounded = float(f"{value:.10g}")
    return 0.0 if abs(rounded) < 1e-12 else rounded


def _numbers(values: FloatArray) -> CommentedSeq:
    sequence = CommentedSeq([_number(value) for value in values])
    sequence.fa.set_flow_style()
    return sequence


def _text(
    name: str, source: str, bodies: CommentedSeq, outputs: list[str], tags: dict[str, str], base: FloatArray
) -> str:
    data: Any = CommentedMap()
    data["name"] = name
    data["description"] = f"Skeleton made from {source}; the first joint is at {base.tolist()} m in the URDF's base."
    data["defaults"] = CommentedMap({"source": source, "tolerance": 0.03})
    data["gravity"] = _numbers(np.array([0, 0, -9.81]))
    data["bodies"] = bodies
    pose = CommentedSeq(["x", "y", "z"])
    pose.fa.set_flow_style()
    data["outputs"] = CommentedMap(
        {"tool": CommentedMap({"pose": pose}), "joints": CommentedMap({"coordinates": CommentedSeq(outputs)})}
    )
    data["controlled"] = "joints"
    data["tags"] = CommentedMap(tags)
    stream = io.StringIO()
    yaml = YAML()
    yaml.width = 120
    yaml.indent(mapping=2, sequence=4, offset=2)
    yaml.dump(data, stream)
    return stream.getvalue()
