"""Text of the robot file of an arm from an MJCF."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any

import numpy as np
from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap, CommentedSeq

from flexros.robot.exchange.imported import import_defaults
from flexros.robot.exchange.slanted_axis import roll_pitch_yaw
from flexros.robot.quantity import unit_of

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from flexros.arrays import FloatArray
    from flexros.robot.exchange.mjcf.arm import ArmJoint, MjcfArm
    from flexros.robot.exchange.mjcf.axes import ArmAxis

SMALL = 1e-13
"""Values below are round-off of the frames, and zero [m, kg m2] (chosen)."""


def robot_text(model: Any, name: str, source: str, arm: MjcfArm, axes: Sequence[ArmAxis], delay: float) -> str:
    """Return the robot file (YAML).

    Args:
        model: The compiled model, mujoco.MjModel.
        name: Name of the robot.
        source: Name of the MJCF.
        arm: The arm.
        axes: Its axes, one body each.
        delay: Delay of all commands [s].
    """
    data: Any = CommentedMap()
    data["name"] = name
    turned = "" if np.allclose(arm.frame, np.eye(3)) else f", turned by {arm.frame.tolist()} (x, y, z in its world)"
    base = [_number(value) for value in arm.joints[0].anchor]
    data["description"] = f"From {source}; the first joint is at {base} m of its world{turned}."
    data["defaults"] = CommentedMap(import_defaults(source))
    data["gravity"] = _numbers(arm.gravity)
    data["sample_time"] = float(model.opt.timestep)
    data.yaml_add_eol_comment("step of the simulator: state that of the controller where it is longer", "sample_time")
    if delay:
        data["delay"] = delay
    following = [axis.joint.anchor for axis in axes[1:]]
    data["bodies"] = CommentedSeq(
        _body(model, axis, following[k] if k < len(following) else None) for k, axis in enumerate(axes)
    )
    last = axes[-1].joint
    data["tool"] = CommentedMap({"position": _numbers(last.frame.T @ (arm.end - last.anchor))})
    pose = CommentedSeq(["x", "y", "z"])
    pose.fa.set_flow_style()
    motors = CommentedSeq(axis.arm_coordinate for axis in axes if axis.is_motor)
    joints = CommentedMap({"coordinates": motors})
    data["outputs"] = CommentedMap({"tool": CommentedMap({"pose": pose}), "joints": joints})
    data["controlled"] = "joints"
    named = {axis.coordinate: axis.joint.name for axis in axes}
    named |= {axis.arm_coordinate: axis.deflection.name for axis in axes if axis.deflection}
    tags = {f"{coordinate}.joint": joint for coordinate, joint in named.items() if joint}
    tags |= {f"{axis.coordinate}.joint_sign": "-1" for axis in axes if axis.joint.sign < 0}
    data["tags"] = CommentedMap(tags)
    stream = io.StringIO()
    yaml = YAML()
    yaml.width = 1000
    yaml.indent(mapping=2, sequence=4, offset=2)
    yaml.dump(data, stream)
    return stream.getvalue()


def _body(model: Any, axis: ArmAxis, following: FloatArray | None) -> CommentedMap:
    carrier, turn = axis.carrier, axis.joint.frame.T
    body = CommentedMap({"label": carrier.body})
    if carrier.mass > 0:
        body["mass"] = _number(carrier.mass)
        body["center_of_mass"] = _numbers(turn @ (carrier.center - axis.joint.anchor))
        pairs = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
        tensor = turn @ carrier.inertia @ turn.T
        inertia = CommentedMap({key: _number(tensor[at]) for key, at in pairs.items()})
        inertia.fa.set_flow_style()
        body["inertia"] = inertia
    if following is not None:
        body["length"] = _numbers(turn @ (following - axis.joint.anchor))
    if not np.array_equal(axis.joint.turn, np.eye(3)):
        body["orientation"] = _numbers(roll_pitch_yaw(axis.joint.turn))
    gear = _gear(model, axis) if axis.is_motor else _spring(model, axis.joint)
    if axis.joint.sign < 0:
        opposite = "its joint has the opposite axis: coordinate and torque have the other sign"
        gear.yaml_set_start_comment(opposite, indent=10)
    body["directions"] = CommentedMap({axis.direction: gear})
    return body


def _gear(model: Any, axis: ArmAxis) -> CommentedMap:
    """Return the direction of a motor."""
    joint, actuator = axis.joint, axis.actuator
    dof = int(model.jnt_dofadr[joint.index])
    motor = CommentedMap({"inertia": float(model.dof_armature[dof]) + (actuator.armature if actuator else 0.0)})
    motor["viscous_friction"] = float(model.dof_damping[dof]) + (actuator.damping if actuator else 0.0)
    if actuator and actuator.gear not in (0.0, 1.0):
        motor["gear_ratio"] = abs(actuator.gear)
    if actuator and actuator.torque_limit is not None:
        motor["torque_limit"] = actuator.torque_limit
    if actuator and actuator.follows:
        servo = CommentedMap({"stiffness": actuator.kp, "damping": actuator.kv})
        servo.fa.set_flow_style()
        motor["servo"] = servo
    motor.fa.set_flow_style()
    if axis.deflection is not None:
        gear = _spring(model, axis.deflection)
        gear["motor"] = motor
        return gear
    gear = CommentedMap({"spring": "rigid", "motor": motor})
    unit = unit_of("stiffness", joint.rotary)
    gear.yaml_add_eol_comment(f"or the stiffness of the gear [{unit}], then also its damper", "spring")
    return gear


def _spring(model: Any, joint: ArmJoint) -> CommentedMap:
    damping = float(model.dof_damping[model.jnt_dofadr[joint.index]])
    return CommentedMap({"spring": float(model.jnt_stiffness[joint.index]), "damper": damping})


def _number(value: float) -> float:
    return 0.0 if abs(value) < SMALL else float(f"{value:.15g}")


def _numbers(values: Iterable[float] | FloatArray) -> CommentedSeq:
    sequence = CommentedSeq([_number(float(value)) for value in values])
    sequence.fa.set_flow_style()
    return sequence
