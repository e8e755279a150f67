"""A robot file as a skeleton from a URDF: geometry and inertia are taken over, springs are left to the user."""

from __future__ import annotations

import io
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree

import numpy as np
from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap, CommentedSeq
from scipy.spatial.transform import Rotation

from flexros.errors import InputError

if TYPE_CHECKING:
    from pathlib import Path

    from flexros.arrays import FloatArray

MOVABLE = ("revolute", "continuous", "prismatic")
LARGEST_FILE = 50_000_000
"""Bytes beyond which a file is not taken for a URDF."""


@dataclass(frozen=True)
class _Joint:
    name: str
    kind: str
    child: str
    origin: FloatArray
    rotation: FloatArray
    axis: FloatArray
    effort: float


def skeleton_from_urdf(file: Path) -> str:
    """Write a robot file from a URDF with one serial chain.

    All frames of a robot file are parallel to the base at zero; the URDF's inertias are turned accordingly. Every
    gear is declared rigid at first: the user replaces the word by a stiffness, and adds elastic directions.

    Args:
        file: The URDF.

    Returns:
        Text of the robot file (YAML).

    Raises:
        InputError: No URDF, a branching chain, or a joint axis that is not along a coordinate axis at zero.
    """
    root = _parse(file)
    links = {link.get("name", ""): link for link in root.findall("link")}
    joints = _chain(root, file)
    bodies = CommentedSeq()
    outputs: list[str] = []
    rotation = np.eye(3)
    length_before = np.zeros(3)
    for joint in joints:
        offset = rotation @ joint.origin
        if bodies:
            bodies[-1]["length"] = _numbers(offset)
        else:
            length_before = offset
        rotation = rotation @ joint.rotation
        body = _body(links[joint.child], rotation)
        if joint.kind in MOVABLE:
            direction = _direction(joint, rotation, file)
            body["directions"] = CommentedMap({direction: _gear(joint)})
            outputs.append(f"body_{len(bodies) + 1}.{direction}")
        bodies.append(body)
    if not outputs:
        raise InputError(f"{file}: no revolute, continuous or prismatic joint was found; give the URDF of a robot arm")
    return _text(root.get("name", file.stem), file.name, bodies, outputs, length_before)


def _parse(file: Path) -> ElementTree.Element:
    try:
        if file.stat().st_size > LARGEST_FILE:
            raise InputError(f"{file} is larger than {LARGEST_FILE // 1_000_000} MB; give a URDF file")
        text = file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"cannot read {file}: {error}; give the path of a URDF file") from error
    if "<!ENTITY" in text or "<!DOCTYPE" in text:
        raise InputError(f"{file} has a document type definition, which a URDF does not need; remove it")
    try:
        root = ElementTree.fromstring(text)  # noqa: S314 - entities are refused above
    except ElementTree.ParseError as error:
        raise InputError(f"{file} is not XML ({error}); give a URDF file (run xacro first)") from error
    if root.tag != "robot":
        raise InputError(f"{file} starts with <{root.tag}>, but a URDF starts with <robot>; give a URDF file")
    return root


def _vector(element: ElementTree.Element | None, key: str, default: str) -> FloatArray:
    text = default if element is None else element.get(key, default)
    return np.array([float(part) for part in text.split()])


def _chain(root: ElementTree.Element, file: Path) -> list[_Joint]:
    """Follow the joints from the base link; a side branch without movable joints (tool frames) is left out."""
    children: dict[str, list[_Joint]] = {}
    is_child = set()
    for element in root.findall("joint"):
        parent, child = element.find("parent"), element.find("child")
        if parent is None or child is None:
            raise InputError(f"{file}: joint '{element.get('name')}' lacks <parent> or <child>; correct the URDF")
        origin, limit = element.find("origin"), element.find("limit")
        joint = _Joint(
            name=element.get("name", ""),
            kind=element.get("type", "fixed"),
            child=child.get("link", ""),
            origin=_vector(origin, "xyz", "0 0 0"),
            rotation=Rotation.from_euler("xyz", _vector(origin, "rpy", "0 0 0")).as_matrix(),
            axis=_vector(element.find("axis"), "xyz", "1 0 0"),
            effort=0.0 if limit is None else float(limit.get("effort", "0")),
        )
        children.setdefault(parent.get("link", ""), []).append(joint)
        is_child.add(joint.child)
    bases = [name for name in (link.get("name", "") for link in root.findall("link")) if name not in is_child]
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
    return joint.kind in MOVABLE or any(_movable_below(below, children) for below in children.get(joint.child, []))


def _direction(joint: _Joint, rotation: FloatArray, file: Path) -> str:
    axis = rotation @ (joint.axis / np.linalg.norm(joint.axis))
    index = int(np.argmax(np.abs(axis)))
    if abs(axis[index]) < 1 - 1e-6:
        raise InputError(
            f"{file}: joint '{joint.name}' turns about {np.round(axis, 4).tolist()} at zero, but axes must lie "
            "along x, y or z of the base; turn the base frame or the zero pose"
        )
    return ("t" if joint.kind == "prismatic" else "r") + "xyz"[index]


def _gear(joint: _Joint) -> CommentedMap:
    motor = CommentedMap({"inertia": 0, "viscous_friction": 0})
    if joint.effort > 0:
        motor["torque_limit"] = joint.effort
    motor.fa.set_flow_style()
    gear = CommentedMap({"spring": "rigid", "damper": 0, "motor": motor})
    gear.yaml_add_eol_comment("replace by the gear's stiffness [Nm/rad]; then give damper and motor inertia", "spring")
    if np.min(joint.axis) < -0.5:
        gear.yaml_set_start_comment("the URDF's axis points the other way: its joint angle has the opposite sign")
    return gear


def _body(link: ElementTree.Element, rotation: FloatArray) -> CommentedMap:
    body = CommentedMap({"label": link.get("name", "")})
    inertial = link.find("inertial")
    if inertial is None:
        return body
    mass, tensor, origin = inertial.find("mass"), inertial.find("inertia"), inertial.find("origin")
    body["mass"] = float(mass.get("value", "0")) if mass is not None else 0.0
    body["center_of_mass"] = _numbers(rotation @ _vector(origin, "xyz", "0 0 0"))
    if tensor is not None:
        entries = {key: float(tensor.get(f"i{key}", "0")) for key in ("xx", "yy", "zz", "xy", "xz", "yz")}
        J = np.array(
            [
                [entries["xx"], entries["xy"], entries["xz"]],
                [entries["xy"], entries["yy"], entries["yz"]],
                [entries["xz"], entries["yz"], entries["zz"]],
            ]
        )
        turn = rotation @ Rotation.from_euler("xyz", _vector(origin, "rpy", "0 0 0")).as_matrix()
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


def _text(name: str, source: str, bodies: CommentedSeq, outputs: list[str], base: FloatArray) -> str:
    data: Any = CommentedMap()
    data["name"] = name
    data["description"] = f"Skeleton made from {source}; the first joint lies at {base.tolist()} m of the URDF's base."
    data["defaults"] = CommentedMap({"source": source, "tolerance": 0.03})
    data["gravity"] = _numbers(np.array([0, 0, -9.81]))
    data["bodies"] = bodies
    pose = CommentedSeq(["x", "y", "z"])
    pose.fa.set_flow_style()
    data["outputs"] = CommentedMap(
        {"tool": CommentedMap({"pose": pose}), "joints": CommentedMap({"coordinates": CommentedSeq(outputs)})}
    )
    data["controlled"] = "joints"
    stream = io.StringIO()
    yaml = YAML()
    yaml.width = 120
    yaml.indent(mapping=2, sequence=4, offset=2)
    yaml.dump(data, stream)
    return stream.getvalue()
