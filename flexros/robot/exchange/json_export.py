"""Export of joint and body numbers as JSON, for scripts and for the actuator settings of Isaac Lab."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from flexros.json_text import json_text
from flexros.robot.exchange.joint_names import tagged
from flexros.robot.exchange.numbers import Export, Written
from flexros.robot.quantity import unit_of
from flexros.robot.spring import Spring

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.robot import Robot
    from flexros.robot.exchange.numbers import JointNumbers, RepairedNumbers


def json_export(robot: Robot, numbers: RepairedNumbers, joints: Mapping[str, str]) -> Export:
    """Return the numbers of all joints on the joint side, in SI units, as JSON.

    The part `isaac_lab` has the names of its ActuatorBaseCfg, each a mapping from joint to value: friction as static
    and dynamic friction torque (Isaac Sim 5.0 and later; 4.5 expects a coefficient), viscous friction, armature.

    Args:
        robot: The robot with the changes of its effects.
        numbers: Its numbers on the joint side.
        joints: Name of the joint in the user's model, by motor; default: the tag of the robot file, else the motor.
    """
    squared = robot.motors[0].gear_ratio ** 2 if robot.spec.coordinates == "motor" else 1.0
    names = {
        joint.motor: joints.get(joint.motor) or tagged(robot, joint.motor) or joint.motor for joint in numbers.joints
    }
    servos = any(joint.servo_stiffness is not None for joint in numbers.joints)
    servo_gains = (("stiffness", "servo_stiffness"), ("damping", "servo_damping")) if servos else ()
    content: dict[str, Any] = {
        "schema": 1,
        "robot": robot.name,
        "gravity": {"value": list(robot.spec.gravity.value), "unit": "m/s2"},
        "joints": [_joint(joint, names[joint.motor]) for joint in numbers.joints],
        "springs": [
            {
                "location": joint.name,
                "stiffness": squared * joint.direction.spring.at_zero,
                "damping": squared * joint.direction.damper.value,
                "units": {kind: unit_of(kind, joint.rotary) for kind in ("stiffness", "damping")},
            }
            for joint in robot.joints
            if isinstance(joint.direction.spring, Spring)
        ],
        "bodies": [asdict(body) for body in numbers.bodies],
        "isaac_lab": {
            key: {names[joint.motor]: value for joint in numbers.joints if (value := getattr(joint, own)) is not None}
            for key, own in (
                ("friction", "friction"),
                ("dynamic_friction", "friction"),
                ("viscous_friction", "damping"),
                ("armature", "armature"),
                ("effort_limit", "torque_limit"),
                *servo_gains,
            )
        },
        "not_held": [asdict(each) for each in numbers.not_held],
    }
    written = tuple(
        Written(joint.motor, quantity, f"joints {names[joint.motor]} {key}", None, float(value), unit)
        for joint in numbers.joints
        for quantity, key, unit in _rows(joint)
        if (value := getattr(joint, key)) is not None
    )
    return Export(json_text(content), written, numbers.not_held)


def _rows(joint: JointNumbers) -> tuple[tuple[str, str, str], ...]:
    servo = (
        ("servo stiffness", "servo_stiffness", unit_of("stiffness", joint.rotary)),
        ("servo damping", "servo_damping", unit_of("damping", joint.rotary)),
        ("lag of the control", "servo_lag", "s"),
    )
    return (
        ("viscous friction", "damping", unit_of("damping", joint.rotary)),
        ("dry friction", "friction", unit_of("torque", joint.rotary)),
        ("rotor inertia", "armature", unit_of("inertia", joint.rotary)),
        ("stiffness of the gear", "stiffness", unit_of("stiffness", joint.rotary)),
        ("torque limit", "torque_limit", unit_of("torque", joint.rotary)),
        ("torque gain", "torque_gain", "1"),
        ("delay", "delay", "s"),
        ("gear ratio", "gear_ratio", "1"),
        ("zero of the encoder", "zero", unit_of("position", joint.rotary)),
        *(servo if joint.servo_stiffness is not None else ()),
    )


def _joint(joint: JointNumbers, name: str) -> dict[str, Any]:
    absent = ("servo_stiffness", "servo_damping", "servo_lag") if joint.servo_stiffness is None else ()
    return {
        "joint": name,
        **{key: value for key, value in asdict(joint).items() if key not in absent},
        "rotor_inertia": joint.armature / joint.gear_ratio**2,
        "units": {key: unit for _, key, unit in _rows(joint)},
    }
