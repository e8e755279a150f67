"""Actuators of a compiled MJCF, as numbers of the joint that they drive."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flexros.robot.exchange.mjcf.mujoco_model import mujoco_package


@dataclass(frozen=True)
class JointActuator:
    """What drives a joint, on the joint side.

    Attributes:
        names: Names of the actuators of the joint.
        gear: Length of the first actuator per joint position [1].
        torque_limit: Largest absolute torque [Nm or N], None for no limit.
        armature: Inertia that the actuators add [kg m2 or kg].
        damping: Viscous friction that they add [Nm s/rad or N s/m].
        gain: Torque per control, of the first [Nm or N per unit of the control].
        kp: Proportional gain of a position servo [Nm/rad or N/m], 0 for none.
        follows: Whether it is a servo whose control is the position of the joint, times its gear.
        kv: Gain of the speed [Nm s/rad or N s/m], 0 for none.
        delay: Delay of the control [s].
        time_constant: Time constant of a first-order lag [s], 0 for none.
    """

    names: tuple[str, ...]
    gear: float
    torque_limit: float | None
    armature: float
    damping: float
    gain: float
    kp: float
    kv: float
    follows: bool
    delay: float
    time_constant: float


def actuators_of(model: Any, joint: int) -> list[int]:
    """Return the indices of the actuators that drive a joint directly."""
    kinds = mujoco_package().mjtTrn
    direct = (int(kinds.mjTRN_JOINT), int(kinds.mjTRN_JOINTINPARENT))
    return [
        a
        for a in range(model.nu)
        if int(model.actuator_trntype[a]) in direct and int(model.actuator_trnid[a, 0]) == joint
    ]


def joint_actuator(model: Any, joint: int) -> JointActuator | None:
    """Return what drives a joint; None for a joint without an actuator."""
    found = actuators_of(model, joint)
    if not found:
        return None
    enums = mujoco_package()
    first = found[0]
    gear = float(model.actuator_gear[first, 0])
    gains, biases = model.actuator_gainprm[first], model.actuator_biasprm[first]
    servo = int(model.actuator_biastype[first]) == int(enums.mjtBias.mjBIAS_AFFINE)
    lags = {int(enums.mjtDyn.mjDYN_FILTER), int(enums.mjtDyn.mjDYN_FILTEREXACT)}
    return JointActuator(
        names=tuple(str(model.actuator(a).name) for a in found),
        gear=gear,
        torque_limit=_torque_limit(model, joint, found, servo),
        armature=added(model, found, "actuator_armature"),
        damping=added(model, found, "actuator_damping"),
        gain=float(gains[0]) * gear,
        kp=-float(biases[1]) * gear**2 if servo else 0.0,
        kv=-float(biases[2]) * gear**2 if servo else 0.0,
        follows=servo
        and int(model.actuator_dyntype[first]) in {int(enums.mjtDyn.mjDYN_NONE), *lags}
        and biases[1] < 0
        and biases[0] == 0
        and bool(np.isclose(gains[0], -biases[1], rtol=1e-9)),
        delay=float(np.max(getattr(model, "actuator_delay", np.zeros(model.nu))[found])),
        time_constant=float(model.actuator_dynprm[first, 0]) if int(model.actuator_dyntype[first]) in lags else 0.0,
    )


def added(model: Any, actuators: list[int], name: str) -> float:
    """Return what actuators add to their joint, times the square of their gear; zero in versions without it."""
    values = np.reshape(getattr(model, name, np.zeros(model.nu)), (model.nu, -1))[:, 0]
    return float(np.sum(values[actuators] * model.actuator_gear[actuators, 0] ** 2))


def _torque_limit(model: Any, joint: int, actuators: list[int], servo: bool) -> float | None:
    limits = []
    first = actuators[0]
    gear, gain = abs(float(model.actuator_gear[first, 0])), abs(float(model.actuator_gainprm[first, 0]))
    if model.actuator_forcelimited[first]:
        limits.append(gear * float(np.abs(model.actuator_forcerange[first]).max()))
    if model.actuator_ctrllimited[first] and not servo:
        limits.append(gear * gain * float(np.abs(model.actuator_ctrlrange[first]).max()))
    if model.jnt_actfrclimited[joint]:
        limits.append(float(np.abs(model.jnt_actfrcrange[joint]).max()))
    return min((limit for limit in limits if limit > 0), default=None)
