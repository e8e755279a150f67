"""Robot file from an MJCF: geometry, inertia, friction, rotor inertia and limits of one serial arm."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.robot.exchange.imported import ImportedEffect, ImportedJoint, ImportedRobot
from flexros.robot.exchange.mjcf.arm import find_arm
from flexros.robot.exchange.mjcf.axes import axes_of
from flexros.robot.exchange.mjcf.mujoco_model import compile_file
from flexros.robot.exchange.mjcf.robot_text import robot_text
from flexros.robot.exchange.numbers import NotHeld
from flexros.robot.quantity import unit_of

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from flexros.robot.exchange.mjcf.actuators import JointActuator
    from flexros.robot.exchange.mjcf.arm import ArmJoint, MjcfArm
    from flexros.robot.exchange.mjcf.axes import ArmAxis


BALANCED = (
    "all bodies have gravcomp 1, so MuJoCo balances the whole weight: the robot file has gravity [0, 0, 0]; where the "
    "log is of a robot that carries its weight with its motors, write its gravity there"
)
"""Note of an arm without weight."""


def robot_from_mjcf(file: Path, end: str = "") -> ImportedRobot:
    """Return a robot file, and effects for what it cannot state, from one serial arm of an MJCF.

    MuJoCo compiles the file, so defaults, angles and inertias of geoms are resolved. Joints with an actuator become
    motors, with an elastic gear where a joint with a spring on the same axis follows; those without become elastic
    directions with stiffness and damping. Where no joint has an actuator, all are motors.

    Args:
        file: The MJCF.
        end: Name of the body at the end of the arm; default: the only possible one.

    Raises:
        InputError: MuJoCo is missing or refuses the file, or it holds no serial arm of hinges and slides.
    """
    model = compile_file(file)
    arm = find_arm(model, str(file), end)
    axes = axes_of(model, arm)
    effects: list[ImportedEffect] = []
    joints: list[ImportedJoint] = []
    not_held = _not_held_of_model(model, arm) + _partly_balanced(model, arm, axes)
    for axis in axes:
        effects += _effects(model, axis.coordinate, axis.joint, axis.actuator)
        not_held += _not_held(model, axis.coordinate, axis.joint, axis.actuator)
        joints.append(_imported(model, axis.coordinate, axis.joint))
        if axis.deflection is not None:
            not_held += _not_held(model, axis.arm_coordinate, axis.deflection, None)
            joints.append(_imported(model, axis.arm_coordinate, axis.deflection))
    delays = {axis.actuator.delay for axis in axes if axis.actuator}
    common = len(delays) == 1  # then it is the delay of the robot file
    return ImportedRobot(
        text=robot_text(model, file.stem, file.name, arm, axes, max(delays) if common else 0.0),
        effects=tuple(effect for effect in effects if effect.effect != "delay" or not common),
        joints=tuple(joints),
        not_held=tuple(not_held),
        notes=(BALANCED,) if arm.weightless else (),
    )


def _imported(model: Any, coordinate: str, joint: ArmJoint) -> ImportedJoint:
    return ImportedJoint(coordinate, joint.name, joint.sign, float(model.qpos0[model.jnt_qposadr[joint.index]]))


def _dof(model: Any, joint: ArmJoint) -> int:
    return int(model.jnt_dofadr[joint.index])


def _effects(model: Any, name: str, joint: ArmJoint, actuator: JointActuator | None) -> list[ImportedEffect]:
    if not name.startswith("motor_"):
        return []
    found = []
    friction = float(model.dof_frictionloss[_dof(model, joint)])
    if friction > 0:
        found.append(ImportedEffect("coulomb_friction", name, "level", friction, unit_of("torque", joint.rotary)))
    if actuator and actuator.time_constant > 0 and not actuator.follows:
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
        if actuator.follows:
            add("lag of the control", actuator.time_constant, "s", "a servo of a robot file has a delay, but no lag")
            if actuator.gear != 1:
                add("gear of the servo", actuator.gear, "1", "divide logged controls by it: commands are positions")
        else:
            servo = "the control of this loop is not the position of the joint"
            add("kp", actuator.kp, unit_of("stiffness", rotary), servo)
            add("kv", actuator.kv, unit_of("damping", rotary), servo)
        if actuator.kp == actuator.kv == 0 and actuator.gain != 1:
            add("gear times gain", actuator.gain, f"{torque} per control", "multiply logged controls by it")
        if len(actuator.names) > 1:
            found.append(NotHeld(name, "actuators", ", ".join(actuator.names), "only the first one is imported"))
    return found


def _partly_balanced(model: Any, arm: MjcfArm, axes: Sequence[ArmAxis]) -> list[NotHeld]:
    """List balanced weights of an arm of which not all bodies are balanced, with the effect that stands for them."""
    if not np.any(arm.gravity):
        return []
    found = []
    for axis in axes:
        heavy = [body for body in axis.carrier.bodies if model.body_mass[body] > 0]
        shares = {float(model.body_gravcomp[body]) for body in heavy}
        for body in (each for each in heavy if model.body_gravcomp[each]):
            share = float(model.body_gravcomp[body])
            reason = "MuJoCo balances this share of its weight, but the robot file carries it all; "
            if len(shares) == 1:
                reason += f"add to the patch: gravity_error at body_{axis.number}, relative {-share:.6g}"
            else:
                others = f"the other bodies of body_{axis.number}"
                reason += f"give {others} the same gravcomp, then gravity_error can state it"
            found.append(NotHeld(str(model.body(body).name), "gravcomp", f"{share:.6g}", reason))
    return found


def _not_held_of_model(model: Any, arm: MjcfArm) -> list[NotHeld]:
    found = [
        NotHeld(joint, "joint", "held at its reference", "it is beside the chain; its bodies move with the arm")
        for joint in arm.frozen
    ]
    for key in ("density", "viscosity"):
        if getattr(model.opt, key):
            found.append(NotHeld("all", key, f"{getattr(model.opt, key):.6g}", "drag of a medium is not modelled"))
    if model.ntendon:
        found.append(NotHeld("all", "tendons", str(model.ntendon), "springs and actuators of tendons are omitted"))
    return found
