"""Actuators of a compiled MJCF, as numbers of the joint that they drive."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.robot.exchange.mjcf.mujoco_model import mujoco_package

if TYPE_CHECKING:
    from flexros.arrays import FloatArray


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
        constant: Torque without a control [Nm or N].
        variable: Gains that depend on position or speed, or a law of another kind, in words; empty for none.
        cut: Controls of a servo that MuJoCo cuts: the smallest and the largest that it takes, None for no limit.
        uneven: Ranges of torque whose sides differ, by their attribute [Nm or N].
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
    constant: float
    variable: str
    cut: tuple[float, float] | None
    uneven: dict[str, tuple[float, float]]


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
        kp=0.0 - float(biases[1]) * gear**2 if servo else 0.0,  # 0.0 - 0.0 has no sign, unlike -0.0
        kv=0.0 - float(biases[2]) * gear**2 if servo else 0.0,
        follows=servo
        and int(model.actuator_dyntype[first]) in {int(enums.mjtDyn.mjDYN_NONE), *lags}
        and biases[1] < 0
        and bool(np.isclose(gains[0], -biases[1], rtol=1e-9)),
        delay=float(np.max(getattr(model, "actuator_delay", np.zeros(model.nu))[found])),
        time_constant=float(model.actuator_dynprm[first, 0]) if int(model.actuator_dyntype[first]) in lags else 0.0,
        constant=float(biases[0]) * gear if servo else 0.0,
        variable=_variable(model, first),
        cut=_pair(model.actuator_ctrlrange[first]) if servo and model.actuator_ctrllimited[first] else None,
        uneven={key: (low, high) for key, low, high in _ranges(model, joint, first, servo) if low != -high},
    )


def added(model: Any, actuators: list[int], name: str) -> float:
    """Return what actuators add to their joint, times the square of their gear; zero in versions without it."""
    values = np.reshape(getattr(model, name, np.zeros(model.nu)), (model.nu, -1))[:, 0]
    return float(np.sum(values[actuators] * model.actuator_gear[actuators, 0] ** 2))


def _variable(model: Any, actuator: int) -> str:
    """Return in words what of an actuator is no constant gain and no linear law."""
    enums = mujoco_package()
    gain, bias = enums.mjtGain(model.actuator_gaintype[actuator]), enums.mjtBias(model.actuator_biastype[actuator])
    slopes = model.actuator_gainprm[actuator, 1:3]
    if gain == enums.mjtGain.mjGAIN_AFFINE and np.any(slopes):
        return f"{slopes[0]:.6g} per position, {slopes[1]:.6g} per speed"
    if gain not in (enums.mjtGain.mjGAIN_FIXED, enums.mjtGain.mjGAIN_AFFINE):
        return f"gaintype {gain.name.rpartition('_')[2].lower()}"
    if bias not in (enums.mjtBias.mjBIAS_NONE, enums.mjtBias.mjBIAS_AFFINE):
        return f"biastype {bias.name.rpartition('_')[2].lower()}"
    return ""


def _torque_limit(model: Any, joint: int, actuators: list[int], servo: bool) -> float | None:
    """Return the least of the ranges that limit the torque, each by its larger side [Nm or N]; None for no limit."""
    limits = [max(abs(low), abs(high)) for _, low, high in _ranges(model, joint, actuators[0], servo)]
    return min((limit for limit in limits if limit > 0), default=None)


def _ranges(model: Any, joint: int, first: int, servo: bool) -> list[tuple[str, float, float]]:
    """Return the ranges that limit the torque of a joint, by their attribute [Nm or N]."""
    found = []
    gear, gain = float(model.actuator_gear[first, 0]), float(model.actuator_gainprm[first, 0])
    if model.actuator_forcelimited[first]:
        found.append(("forcerange", *_pair(gear * model.actuator_forcerange[first])))
    if model.actuator_ctrllimited[first] and not servo:
        found.append(("ctrlrange", *_pair(gear * gain * model.actuator_ctrlrange[first])))
    if model.jnt_actfrclimited[joint]:
        found.append(("actuatorfrcrange", *_pair(model.jnt_actfrcrange[joint])))
    return found


def _pair(values: FloatArray) -> tuple[float, float]:
    low, high = sorted(float(value) + 0.0 for value in values)  # no negative zero
    return low, high
