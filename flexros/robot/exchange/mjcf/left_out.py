"""What an import of an MJCF leaves out, with its size and what to do instead."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.robot.exchange.mjcf.mujoco_model import mujoco_package
from flexros.robot.exchange.numbers import NotHeld
from flexros.robot.quantity import unit_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.robot.exchange.mjcf.actuators import JointActuator
    from flexros.robot.exchange.mjcf.arm import ArmJoint, MjcfArm
    from flexros.robot.exchange.mjcf.axes import ArmAxis


def left_out_of_joint(model: Any, name: str, joint: ArmJoint, actuator: JointActuator | None) -> list[NotHeld]:
    """List the numbers of a joint that neither robot file nor effects hold.

    Args:
        model: The compiled model, mujoco.MjModel.
        name: Its coordinate in the robot file.
        joint: The joint.
        actuator: What drives it; None without an actuator.
    """
    found: list[NotHeld] = []

    def add(quantity: str, value: float, unit: str, reason: str) -> None:
        if value:
            found.append(NotHeld(name, quantity, f"{value:.6g} {unit}".strip(), reason))

    dof, rotary = int(model.jnt_dofadr[joint.index]), joint.rotary
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
        found += _limits(name, joint, actuator)
        add("constant torque", joint.sign * actuator.constant, torque, "the effect torque_bias states it in the patch")
        if actuator.variable:
            lost = "a gain of a robot file is constant: the torque of this actuator is left out"
            found.append(NotHeld(name, "gain", actuator.variable, lost))
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


def left_out_of_model(model: Any, arm: MjcfArm, axes: Sequence[ArmAxis]) -> list[NotHeld]:
    """List what neither robot file nor effects hold of the model as a whole.

    Args:
        model: The compiled model, mujoco.MjModel.
        arm: The arm.
        axes: Its axes.
    """
    found = [
        NotHeld(joint, "joint", "held at its reference", "it is beside the chain; its bodies move with the arm")
        for joint in arm.frozen
    ]
    for key in ("density", "viscosity"):
        if getattr(model.opt, key):
            found.append(NotHeld("all", key, f"{getattr(model.opt, key):.6g}", "drag of a medium is not modelled"))
    if model.ntendon:
        found.append(NotHeld("all", "tendons", str(model.ntendon), "springs and actuators of tendons are omitted"))
    return found + _partly_balanced(model, arm, axes) + _not_joint_actuators(model, axes) + _switched_off(model)


def _limits(name: str, joint: ArmJoint, actuator: JointActuator) -> list[NotHeld]:
    """List the limits of commands, and of torques that differ on both sides."""
    found = []
    torque = unit_of("torque", joint.rotary)
    if actuator.cut:
        low, high = actuator.cut
        reason = "MuJoCo cuts the commands of the servo there: cut those of a log before its import"
        found.append(NotHeld(name, "ctrlrange", f"{low:.6g} to {high:.6g}", reason))
    for key, (low, high) in actuator.uneven.items():
        reason = "a robot file has one limit for both sides, here the larger one: the torque may pass the smaller one"
        found.append(NotHeld(name, key, f"{low:.6g} to {high:.6g} {torque}", reason))
    return found


def _not_joint_actuators(model: Any, axes: Sequence[ArmAxis]) -> list[NotHeld]:
    """List actuators that drive no joint directly, and joints that have no other."""
    kinds = mujoco_package().mjtTrn
    direct = (int(kinds.mjTRN_JOINT), int(kinds.mjTRN_JOINTINPARENT))
    free = [axis.joint.name for axis in axes if not axis.is_motor and model.jnt_stiffness[axis.joint.index] == 0]
    reason = "only actuators of joints are imported"
    if free:
        reason += f"; in the robot file these joints turn freely (spring 0): {', '.join(free)}; give those that it "
        reason += "drives an actuator <motor> each, with the torque of its moment arm"
    found = []
    for a in range(model.nu):
        kind = int(model.actuator_trntype[a])
        if kind not in direct:
            name = str(model.actuator(a).name) or f"actuator {a}"
            through = kinds(kind).name.rpartition("_")[2].lower()
            found.append(NotHeld(name, "actuator", f"through a {through}", reason))
    return found


def _switched_off(model: Any) -> list[NotHeld]:
    """List actuators that the options of the file switch off."""
    bits = int(model.opt.disableactuator)
    off = [a for a in range(model.nu) if int(model.actuator_group[a]) < 31 and bits >> int(model.actuator_group[a]) & 1]
    if int(model.opt.disableflags) & int(mujoco_package().mjtDisableBit.mjDSBL_ACTUATION):
        off = list(range(model.nu))
    names = ", ".join(str(model.actuator(a).name) or f"actuator {a}" for a in off)
    reason = "an option of the file switches them off; the robot file has them, so their logged commands must be zero"
    return [NotHeld("all", "actuators", names, reason)] if off else []


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
