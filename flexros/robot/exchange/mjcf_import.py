"""Robot file from an MJCF: geometry, inertia, friction, rotor inertia and limits of one serial arm."""

from __future__ import annotations

import io
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap, CommentedSeq

from flexros.robot.exchange.mjcf_actuators import JointActuator, joint_actuator
from flexros.robot.exchange.mjcf_arm import ArmJoint, MjcfArm, find_arm
from flexros.robot.exchange.mujoco_model import compile_file
from flexros.robot.exchange.numbers import NotHeld
from flexros.robot.quantity import unit_of

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from flexros.arrays import FloatArray

SMALL = 1e-13
"""Values below are round-off of the frames, and zero [m, kg m2] (chosen)."""


@dataclass(frozen=True)
class ImportedEffect:
    """A number of the MJCF that a robot file states as an effect.

    Attributes:
        effect: Name of the effect.
        location: Motor or body.
        parameter: Its parameter.
        value: Value of the parameter.
        unit: SI unit.
    """

    effect: str
    location: str
    parameter: str
    value: float
    unit: str


@dataclass(frozen=True)
class ImportedJoint:
    """How a coordinate of the robot follows from a joint of the MJCF: sign (position - reference).

    Attributes:
        coordinate: Motor, or arm coordinate of a joint without an actuator.
        joint: Name of the joint in the MJCF.
        sign: Sign of the coordinate relative to the joint.
        reference: Joint position at the zero of the coordinate [rad or m].
    """

    coordinate: str
    joint: str
    sign: int
    reference: float


@dataclass(frozen=True)
class ImportedRobot:
    """A robot from an MJCF.

    Attributes:
        text: Robot file (YAML).
        effects: Numbers that belong in a patch.
        joints: Where the coordinates come from.
        not_held: Numbers that neither holds.
    """

    text: str
    effects: tuple[ImportedEffect, ...]
    joints: tuple[ImportedJoint, ...]
    not_held: tuple[NotHeld, ...]


def robot_from_mjcf(file: Path, end: str = "") -> ImportedRobot:
    """Return a robot file, and effects for what it cannot state, from one serial arm of an MJCF.

    MuJoCo compiles the file, so defaults, angles and inertias of geoms are resolved. Joints with an actuator become
    motors with rigid gears; those without become elastic directions with stiffness and damping. Where no joint has an
    actuator, all are motors.

    Args:
        file: The MJCF.
        end: Name of the body at the end of the arm; default: the only possible one.

    Raises:
        InputError: MuJoCo is missing or refuses the file, or it holds no serial arm of hinges and slides.
    """
    model = compile_file(file)
    arm = find_arm(model, str(file), end)
    actuators = [joint_actuator(model, joint.index) for joint in arm.joints]
    passive = any(actuators)
    names: list[str] = []
    for k, (joint, actuator) in enumerate(zip(arm.joints, actuators)):
        is_motor = actuator is not None or not passive
        motors = sum(name.startswith("motor_") for name in names)
        names.append(f"motor_{motors + 1}" if is_motor else f"body_{k + 1}.{_direction(joint)}")
    effects: list[ImportedEffect] = []
    not_held = _not_held_of_model(model, arm)
    for name, joint, actuator in zip(names, arm.joints, actuators):
        effects += _effects(model, name, joint, actuator)
        not_held += _not_held(model, name, joint, actuator)
    delays = {actuator.delay for actuator in actuators if actuator}
    common = len(delays) == 1  # then it is the delay of the robot file
    return ImportedRobot(
        text=_text(model, file, arm, actuators, names, max(delays) if common else 0.0),
        effects=tuple(effect for effect in effects if effect.effect != "delay" or not common),
        joints=tuple(
            ImportedJoint(name, joint.name, joint.sign, float(model.qpos0[model.jnt_qposadr[joint.index]]))
            for name, joint in zip(names, arm.joints)
        ),
        not_held=tuple(not_held),
    )


def _direction(joint: ArmJoint) -> str:
    return ("r" if joint.rotary else "t") + "xyz"[joint.axis]


def _dof(model: Any, joint: ArmJoint) -> int:
    return int(model.jnt_dofadr[joint.index])


def _effects(model: Any, name: str, joint: ArmJoint, actuator: JointActuator | None) -> list[ImportedEffect]:
    if not name.startswith("motor_"):
        return []
    found = []
    friction = float(model.dof_frictionloss[_dof(model, joint)])
    if friction > 0:
        found.append(ImportedEffect("coulomb_friction", name, "level", friction, unit_of("torque", joint.rotary)))
    if actuator and actuator.time_constant > 0:
        found.append(ImportedEffect("actuator_lag", name, "time_constant", actuator.time_constant, "s"))
    if actuator and actuator.delay > 0:
        found.append(ImportedEffect("delay", name, "time", actuator.delay, "s"))
    return found


def _not_held(model: Any, name: str, joint: ArmJoint, actuator: JointActuator | None) -> list[NotHeld]:
    """List the numbers of a joint that neither robot file nor effects hold."""
    found: list[NotHeld] = []

    def add(quantity: str, value: float, unit: str, reason: str) -> None:
        if value:
            found.append(NotHeld(name, quantity, f"{value:.6g} {unit}".strip(), reason))

    dof, rotary = _dof(model, joint), joint.rotary
    torque, angle = unit_of("torque", rotary), unit_of("position", rotary)
    stiffness = float(model.jnt_stiffness[joint.index])
    address = model.jnt_qposadr[joint.index]
    reference = joint.sign * float(model.qpos_spring[address] - model.qpos0[address])
    if name.startswith("motor_"):
        reason = "a robot file has no spring between an actuated joint and its base"
        add("stiffness", stiffness, unit_of("stiffness", rotary), f"{reason}; rest position {reference:.6g} {angle}")
    else:
        add("frictionloss", float(model.dof_frictionloss[dof]), torque, "dry friction is an effect of motors")
        add("armature", float(model.dof_armature[dof]), unit_of("inertia", rotary), "rotor inertia needs a motor")
        add("springref", reference if stiffness else 0.0, angle, "springs of a robot file are relaxed at zero")
    for array, key, unit in (
        ("dof_dampingpoly", dof, f"{torque} s^n/{angle}^n"),
        ("jnt_stiffnesspoly", joint.index, f"{torque}/{angle}^n"),
    ):
        for order, value in enumerate(np.ravel(getattr(model, array, np.zeros((model.nv, 1)))[key]), start=2):
            quantity = f"{array.split('_')[1].removesuffix('poly')}, order {order}"
            add(quantity, float(value), unit.replace("^n", f"^{order}"), "laws of a robot file are linear here")
    if actuator:
        servo = "the loop of a servo belongs to the controller, not to the robot"
        add("kp", actuator.kp, unit_of("stiffness", rotary), servo)
        add("kv", actuator.kv, unit_of("damping", rotary), servo)
        if actuator.kp == actuator.kv == 0 and actuator.gain != 1:
            add("gear times gain", actuator.gain, f"{torque} per control", "multiply logged controls by it")
        if len(actuator.names) > 1:
            found.append(NotHeld(name, "actuators", ", ".join(actuator.names), "only the first one is imported"))
    return found


def _not_held_of_model(model: Any, arm: MjcfArm) -> list[NotHeld]:
    found = [
        NotHeld(joint, "joint", "held at its reference", "it is beside the chain; its bodies move with the arm")
        for joint in arm.frozen
    ]
    for key in ("density", "viscosity"):
        if getattr(model.opt, key):
            found.append(NotHeld("all", key, f"{getattr(model.opt, key):.6g}", "drag of a medium is not modelled"))
    compensated = sorted({body for joint in arm.joints for body in joint.bodies if model.body_gravcomp[body]})
    found += [
        NotHeld(
            str(model.body(body).name),
            "gravcomp",
            f"{model.body_gravcomp[body]:.6g}",
            "compensation of weight belongs to the controller; as an error of the model: effect gravity_error",
        )
        for body in compensated
    ]
    if model.ntendon:
        found.append(NotHeld("all", "tendons", str(model.ntendon), "springs and actuators of tendons are omitted"))
    return found


def _text(
    model: Any,
    file: Path,
    arm: MjcfArm,
    actuators: list[JointActuator | None],
    names: list[str],
    delay: float,
) -> str:
    data: Any = CommentedMap()
    data["name"] = file.stem
    turned = "" if np.allclose(arm.frame, np.eye(3)) else f", turned by {arm.frame.tolist()} (x, y, z in its world)"
    base = [_number(value) for value in arm.joints[0].anchor]
    data["description"] = f"From {file.name}; the first joint is at {base} m of its world{turned}."
    data["defaults"] = CommentedMap({"source": file.name, "tolerance": 0.03})
    data["gravity"] = _numbers(arm.gravity)
    data["sample_time"] = float(model.opt.timestep)
    if delay:
        data["delay"] = delay
    data["bodies"] = CommentedSeq(
        _body(model, arm, k, actuators[k], name.startswith("motor_")) for k, name in enumerate(names)
    )
    data["tool"] = CommentedMap({"position": _numbers(arm.end - arm.joints[-1].anchor)})
    pose = CommentedSeq(["x", "y", "z"])
    pose.fa.set_flow_style()
    motors = [f"body_{k + 1}.{_direction(arm.joints[k])}" for k, name in enumerate(names) if name.startswith("motor_")]
    data["outputs"] = CommentedMap(
        {"tool": CommentedMap({"pose": pose}), "joints": CommentedMap({"coordinates": CommentedSeq(motors)})}
    )
    data["controlled"] = "joints"
    data["tags"] = CommentedMap({f"{name}.joint": joint.name for name, joint in zip(names, arm.joints) if joint.name})
    stream = io.StringIO()
    yaml = YAML()
    yaml.width = 1000
    yaml.indent(mapping=2, sequence=4, offset=2)
    yaml.dump(data, stream)
    return stream.getvalue()


def _body(model: Any, arm: MjcfArm, k: int, actuator: JointActuator | None, is_motor: bool) -> CommentedMap:
    joint = arm.joints[k]
    dof, rotary = _dof(model, joint), joint.rotary
    body = CommentedMap({"label": joint.body})
    if joint.mass > 0:
        body["mass"] = _number(joint.mass)
        body["center_of_mass"] = _numbers(joint.center - joint.anchor)
        pairs = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
        inertia = CommentedMap({key: _number(joint.inertia[at]) for key, at in pairs.items()})
        inertia.fa.set_flow_style()
        body["inertia"] = inertia
    if k + 1 < len(arm.joints):
        body["length"] = _numbers(arm.joints[k + 1].anchor - joint.anchor)
    damping = float(model.dof_damping[dof]) + (actuator.damping if actuator else 0.0)
    gear: Any
    if is_motor:
        motor = CommentedMap({"inertia": float(model.dof_armature[dof]) + (actuator.armature if actuator else 0.0)})
        motor["viscous_friction"] = damping
        if actuator and actuator.gear not in (0.0, 1.0):
            motor["gear_ratio"] = abs(actuator.gear)
        if actuator and actuator.torque_limit is not None:
            motor["torque_limit"] = actuator.torque_limit
        motor.fa.set_flow_style()
        gear = CommentedMap({"spring": "rigid", "motor": motor})
        unit = unit_of("stiffness", rotary)
        gear.yaml_add_eol_comment(f"or the stiffness of the gear [{unit}], then also its damper", "spring")
    else:
        gear = CommentedMap({"spring": float(model.jnt_stiffness[joint.index]), "damper": damping})
    if joint.sign < 0:
        gear.yaml_set_start_comment(
            "its joint has the opposite axis: coordinate and torque have the other sign", indent=10
        )
    body["directions"] = CommentedMap({_direction(joint): gear})
    return body


def _number(value: float) -> float:
    return 0.0 if abs(value) < SMALL else float(f"{value:.15g}")


def _numbers(values: Iterable[float] | FloatArray) -> CommentedSeq:
    sequence = CommentedSeq([_number(float(value)) for value in values])
    sequence.fa.set_flow_style()
    return sequence
