"""Robot file from an MJCF: geometry, inertia, friction, rotor inertia and limits of one serial arm."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from flexros.robot.exchange.imported import ImportedEffect, ImportedJoint, ImportedRobot
from flexros.robot.exchange.mjcf.arm import find_arm
from flexros.robot.exchange.mjcf.axes import axes_of
from flexros.robot.exchange.mjcf.left_out import left_out_of_joint, left_out_of_model
from flexros.robot.exchange.mjcf.mujoco_model import compile_file
from flexros.robot.exchange.mjcf.robot_text import robot_text
from flexros.robot.quantity import unit_of

if TYPE_CHECKING:
    from pathlib import Path

    from flexros.robot.exchange.mjcf.actuators import JointActuator
    from flexros.robot.exchange.mjcf.arm import ArmJoint


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
    not_held = left_out_of_model(model, arm, axes)
    for axis in axes:
        effects += _effects(model, axis.coordinate, axis.joint, axis.actuator)
        not_held += left_out_of_joint(model, axis.coordinate, axis.joint, axis.actuator)
        joints.append(_imported(model, axis.coordinate, axis.joint))
        if axis.deflection is not None:
            not_held += left_out_of_joint(model, axis.arm_coordinate, axis.deflection, None)
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
