"""Skeleton of a robot file from a URDF: geometry and inertia are imported, springs are left to the user."""

from __future__ import annotations

import io
import os
from pathlib import PurePath
from typing import TYPE_CHECKING

import numpy as np
from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap, CommentedSeq

from flexros.config.text_file import read_text
from flexros.errors import InputError
from flexros.input_limits import LARGEST_URDF
from flexros.robot.exchange.imported import ImportedEffect, ImportedJoint, ImportedRobot, import_defaults
from flexros.robot.exchange.slanted_axis import roll_pitch_yaw, turn_to
from flexros.robot.exchange.urdf.tree import MOVABLE, NO_LIMIT, read_tree
from flexros.robot.physical import ROUNDED
from flexros.robot.quantity import unit_of

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from flexros.arrays import FloatArray
    from flexros.robot.exchange.urdf.tree import Inertial, UrdfJoint

ALUMINIUM = 2700.0
"""Density of links whose inertia is rounded to zero, as of light last links, or a placeholder [kg/m3] (chosen)."""


def robot_from_urdf(file: Path, tip: str = "", folder: Path | None = None) -> ImportedRobot:
    """Return a robot file from a URDF with one serial chain, and its dry friction as effects; see `skeleton_from_text`.

    Args:
        file: The URDF.
        tip: Last link of the chain.
        folder: Folder of the robot file, which then names the URDF as its drawing where that has shapes.

    Raises:
        InputError: The file cannot be read, or as in `skeleton_from_text`.
    """
    drawing = "" if folder is None else os.path.relpath(file, folder)
    return _robot(read_text(file, "URDF", LARGEST_URDF), str(file), tip, drawing)


def skeleton_from_text(text: str, file: str, tip: str = "") -> str:
    """Return the text of a robot file (YAML) from that of a URDF with one serial chain.

    The frames of a robot file are parallel to the base at zero; the URDF's inertias are rotated accordingly. The base
    is turned where the first joint is slanted, and gravity with it; a body where a later one is. Every gear is
    initially rigid: the user replaces the word by a stiffness, and adds elastic directions. The tags `motor_1.joint`,
    ... name the joints, `motor_1.joint_sign`, ... are -1 where a joint turns the other way.

    Args:
        text: The URDF.
        file: Where it comes from: a file or a topic.
        tip: Last link of the chain, to which all behind it is fixed, such as the fingers of a gripper; empty for the
            end of the only chain with joints that move.

    Raises:
        InputError: Not a URDF, invalid numbers, a chain that branches or closes, or a joint axis without direction.
    """
    return _robot(text, file, tip).text


def _robot(text: str, file: str, tip: str, drawing: str = "") -> ImportedRobot:
    tree = read_tree(text, file)
    joints = tree.chain(tip)
    if not any(joint.kind in MOVABLE for joint in joints):
        raise InputError(f"{file}: no revolute, continuous or prismatic joint was found; give the URDF of a robot arm")
    _refuse_joints(joints, file)
    bodies = CommentedSeq()
    outputs: list[str] = []
    effects: list[ImportedEffect] = []
    imported: list[ImportedJoint] = []
    tags: dict[str, str] = {}
    base = turned_base(joints)
    rotation = base
    frame = np.eye(3)  # of the body, in the base: turned where an axis is slanted
    length_before = np.zeros(3)
    for joint, inertial in zip(joints, tree.carried(joints), strict=True):
        offset = rotation @ joint.origin
        if bodies:
            bodies[-1]["length"] = _numbers(frame.T @ offset)
        else:
            length_before = joint.origin
        rotation = rotation @ joint.rotation
        turn = np.eye(3)
        if joint.kind in MOVABLE:
            axis = frame.T @ _base_axis(joint, rotation, file)
            index, turn = turn_to(axis)
            frame = frame @ turn
        body = _body(joint.child, inertial, frame.T @ rotation)
        if joint.kind in MOVABLE:
            if not np.array_equal(turn, np.eye(3)):
                body["orientation"] = _numbers(roll_pitch_yaw(turn))
            direction = ("t" if joint.kind == "prismatic" else "r") + "xyz"[index]
            body["directions"] = CommentedMap({direction: _gear(joint, opposite=bool(axis[index] < 0))})
            outputs.append(f"body_{len(bodies) + 1}.{direction}")
            motor = f"motor_{len(outputs)}"
            tags[f"{motor}.joint"] = joint.name
            imported.append(ImportedJoint(motor, joint.name, -1 if axis[index] < 0 else 1, 0.0))
            if joint.friction > 0:
                unit = unit_of("torque", joint.kind != "prismatic")
                effects.append(ImportedEffect("coulomb_friction", motor, "level", joint.friction, unit))
            if axis[index] < 0:
                tags[f"{motor}.joint_sign"] = "-1"
        bodies.append(body)
    path = PurePath(file)
    place = f"Skeleton made from {path.name}; the first joint is at {length_before.tolist()} m in the URDF's base"
    if not np.allclose(base, np.eye(3)):
        place += f", which is turned by {np.round(base, 6).tolist()}"
    head = CommentedMap({"name": tree.name or path.stem, "description": f"{place}."})
    head["defaults"] = CommentedMap(import_defaults(path.name))
    head["gravity"] = _numbers(base @ [0, 0, -9.81])
    if drawing and any(link.find("visual") is not None for link in tree.links.values()):
        head["drawing"] = drawing
    notes = (f"the base link {tree.undeclared}, which the URDF does not declare, is one without mass",)
    written = _text(head, bodies, outputs, tags)
    return ImportedRobot(written, tuple(effects), tuple(imported), (), notes if tree.undeclared else ())


def _refuse_joints(joints: Sequence[UrdfJoint], file: str) -> None:
    """Refuse joints of the chain that a robot file cannot hold: other types, and those that follow another joint."""
    for joint in joints:
        if joint.kind in ("floating", "planar"):
            raise InputError(
                f"{file}: joint '{joint.name}' is {joint.kind}, but a robot here has a fixed base and joints with one "
                "axis; make it fixed, or remove it from the chain"
            )
        if joint.kind in MOVABLE and joint.mimics:
            raise InputError(
                f"{file}: joint '{joint.name}' mimics {joint.mimics}, but a robot here is one open chain of "
                "joints that move on their own; give as tip a link before it, or leave out <mimic> where it has a motor"
            )


def turned_base(joints: Sequence[UrdfJoint]) -> FloatArray:
    """Return the URDF's base in that of the robot file: turned where the first axis that moves is slanted.

    Args:
        joints: The chain of the URDF.

    Returns:
        Rotation, shape (3, 3); the origin of the robot file is at the first joint of the chain.
    """
    rotation = np.eye(3)
    for joint in joints:
        rotation = rotation @ joint.rotation
        if joint.kind in MOVABLE:
            length = float(np.linalg.norm(joint.axis))
            slanted = length > 0 and np.max(np.abs(rotation @ joint.axis)) < (1 - 1e-6) * length
            return rotation.T if slanted else np.eye(3)
    return np.eye(3)


def _base_axis(joint: UrdfJoint, rotation: FloatArray, file: str) -> FloatArray:
    """Return the axis of a joint at zero in the base frame, a unit vector, shape (3,)."""
    length = float(np.linalg.norm(joint.axis))
    if not length > 0:
        raise InputError(
            f"{file}: joint '{joint.name}' has the axis {joint.axis.tolist()}, which has no direction; correct the URDF"
        )
    axis: FloatArray = rotation @ (joint.axis / length)
    return axis


def _gear(joint: UrdfJoint, opposite: bool) -> CommentedMap:
    motor = CommentedMap({"inertia": 0, "viscous_friction": _number(max(joint.damping, 0.0)) or 0})
    if 0 < joint.effort < NO_LIMIT:
        motor["torque_limit"] = joint.effort
    if 0 < joint.velocity < NO_LIMIT:
        motor["speed_limit"] = joint.velocity
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


def _body(label: str, inertial: Inertial | None, rotation: FloatArray) -> CommentedMap:
    """Return the entry of a body whose frame is turned by a rotation at zero."""
    body = CommentedMap({"label": label})
    if inertial is None:
        return body
    body["mass"] = _number(inertial.mass)
    body["center_of_mass"] = _numbers(rotation @ inertial.center)
    J, note = _possible(rotation @ inertial.inertia @ rotation.T, inertial.mass)
    pairs = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
    inertia = CommentedMap({key: _number(J[place]) for key, place in pairs.items() if abs(J[place]) > 1e-12})
    inertia.fa.set_flow_style()
    body["inertia"] = inertia
    if note:
        body.yaml_add_eol_comment(note, "inertia")
    return body


def _possible(inertia: FloatArray, mass: float) -> tuple[FloatArray, str]:
    """Return the nearest inertia that a body can have, and what was wrong with the given one; empty for nothing.

    A body has the inertia tr(S) 1 - S with the second moments S of its mass, which are not negative (Wensing, Kim and
    Slotine 2018); a rounded zero is that of a solid sphere, the least that a body of its density can have.
    """
    if mass > 0 and not np.any(np.abs(inertia) > 1e-12):
        sphere = 0.4 * mass * (3 * mass / (4 * np.pi * ALUMINIUM)) ** (2 / 3)
        return sphere * np.eye(3), "zero or a placeholder in the URDF, so that of a ball of aluminium of this mass"
    moments, axes = np.linalg.eigh(np.trace(inertia) / 2 * np.eye(3) - inertia)
    if 2 * moments[0] >= -ROUNDED * np.linalg.eigvalsh(inertia)[-1]:
        return inertia, ""
    S = np.maximum(moments, 0.0)
    nearest = axes @ np.diag(S.sum() - S) @ axes.T
    return (
        nearest,
        "the nearest one that a body can have: in the URDF one principal moment exceeds the sum of the others",
    )


def _number(value: float) -> float:
    rounded = float(f"{value:.10g}")
    return 0.0 if abs(rounded) < 1e-12 else rounded


def _numbers(values: FloatArray) -> CommentedSeq:
    sequence = CommentedSeq([_number(value) for value in values])
    sequence.fa.set_flow_style()
    return sequence


def _text(data: CommentedMap, bodies: CommentedSeq, outputs: list[str], tags: dict[str, str]) -> str:
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
