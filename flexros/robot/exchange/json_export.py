"""Export of joint and body numbers as JSON, for scripts and for the actuator settings of Isaac Lab."""

from __future__ import annotations

from dataclasses import asdict, replace
from typing import TYPE_CHECKING, Any

from flexros.json_text import json_text
from flexros.robot.exchange.body_inertia import ENTRIES, BodyInertia
from flexros.robot.exchange.joint_names import tagged
from flexros.robot.exchange.numbers import Export, Written
from flexros.robot.quantity import unit_of
from flexros.robot.spring import Spring

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.robot import Robot
    from flexros.robot.exchange.numbers import JointNumbers, RepairedNumbers
    from flexros.robot.symbolic.chain import Joint

FRICTION = unit_of("damping", rotary=True)
"""Unit of friction against the absolute rotation of a body."""


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
    bodies = [replace(own := BodyInertia.of(body), inertia=squared * own.inertia) for body in robot.spec.bodies]
    servos = any(joint.servo_stiffness is not None for joint in numbers.joints)
    servo_gains = (("stiffness", "servo_stiffness"), ("damping", "servo_damping")) if servos else ()
    content: dict[str, Any] = {
        "schema": 1,
        "robot": robot.name,
        "gravity": {"value": list(robot.spec.gravity.value), "unit": "m/s2"},
        "joints": [_joint(joint, names[joint.motor]) for joint in numbers.joints],
        "springs": [spring for joint in robot.joints if (spring := _spring(joint, squared))],
        "bodies": [asdict(replace(body, nominal=None)) | _inertia(own) for body, own in zip(numbers.bodies, bodies)],
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
    written = [
        Written(joint.motor, quantity, f"joints {names[joint.motor]} {key}", None, float(value), unit)
        for joint in numbers.joints
        for quantity, key, unit in _rows(joint)
        if (value := getattr(joint, key)) is not None
    ]
    for spring in content["springs"]:
        for quantity, key in (("stiffness", "stiffness"), ("damper", "damping")):
            place = f"springs {spring['location']} {key}"
            written.append(Written(spring["location"], quantity, place, None, spring[key], spring["units"][key]))
    for body, own in zip(numbers.bodies, bodies):
        name, place = body.body, f"bodies {body.body}"
        written += own.written(name, f"{place} mass", f"{place} center_of_mass", f"{place} inertia")
        for quantity, key, unit in (
            ("weight", "weight_error", "1"),
            ("viscous friction", "viscous_friction", FRICTION),
        ):
            if value := getattr(body, key):
                written.append(Written(name, quantity, f"{place} {key}", None, value, unit))
    for axis, value in zip("xyz", numbers.gravity or ()):
        written.append(Written("base", f"gravity {axis}", "gravity", None, value, "m/s2"))
    return Export(json_text(content), tuple(written), numbers.not_held)


def _spring(joint: Joint, squared: float) -> dict[str, Any]:
    """Return the numbers of the spring of a direction; empty where it is rigid."""
    spring = joint.direction.spring
    if not isinstance(spring, Spring):
        return {}
    return {
        "location": joint.name,
        "stiffness": squared * spring.at_zero,
        "damping": squared * joint.direction.damper.value,
        "units": {kind: unit_of(kind, joint.rotary) for kind in ("stiffness", "damping")},
    }


def _inertia(body: BodyInertia) -> dict[str, Any]:
    """Return mass, centre and inertia of a body in its own frame, with all effects."""
    return {
        "mass": body.mass,
        "center_of_mass": body.center.tolist(),
        "inertia": {entry: float(body.inertia[at]) for entry, at in ENTRIES.items()},
        "units": {"mass": "kg", "center_of_mass": "m", "inertia": "kg m2", "viscous_friction": FRICTION},
    }


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
