"""Control laws of the study, each as a function of at most two numbers that are tuned."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.linalg import solve_continuous_are

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from flexros.arrays import FloatArray
    from flexros.robot import Robot

FILTER = 1e-3
"""Time constant of all filters of differences that are not tuned [s] (chosen)."""
INTEGRAL = 0.2
"""Integral gain of the PID over proportional gain and bandwidth [1] (chosen)."""


@dataclass(frozen=True)
class Axis:
    """Two masses of one axis, the other axes held at home.

    Attributes:
        motor: Inertia of the motor [kgm2].
        link: Inertia of the arm behind the gear, the other axes held [kgm2].
        free: The same with all other axes free [kgm2], which holds above their resonances.
        stiffness: Of the gear [Nm/rad].
        damping: Of the gear [Nms/rad].
        friction: Viscous friction of the motor [Nms/rad].
    """

    motor: float
    link: float
    free: float
    stiffness: float
    damping: float
    friction: float

    @property
    def whole(self) -> float:
        """Inertia of motor and arm together [kgm2]."""
        return self.motor + self.link


def axes_of(robot: Robot) -> tuple[Axis, ...]:
    """Return the two masses of every axis at home."""
    inertia = np.asarray(robot.model.arm_inertia(robot.home, []), dtype=float)
    free = 1.0 / np.diag(np.linalg.inv(inertia))
    axes = []
    for motor, row in zip(robot.joint_names, robot.gear_rows, strict=True):
        joint = robot.joints[row].name
        value = {name: parameter.value for name, parameter in robot.parameters.items()}
        gear = (value[f"{joint}.stiffness"], value[f"{joint}.damping"])
        axes.append(
            Axis(value[f"{motor}.inertia"], inertia[row, row], free[row], *gear, value[f"{motor}.viscous_friction"])
        )
    return tuple(axes)


@dataclass(frozen=True, eq=False)
class Law:
    """A control law of the study.

    Attributes:
        name: Name in texts.
        short: Name in tables.
        text: What it is.
        feedforward: Method of the feedforward.
        links: Whether it measures the links, with encoders.
        settings: Settings of the controller from the axes, the bandwidth w [rad/s] and a second number.
        second: Trial values of the second number; its meaning is in `text`.
        first: Value of the second number where all laws have the same bandwidth.
    """

    name: str
    short: str
    text: str
    feedforward: str
    settings: Callable[[Sequence[Axis], float, float], dict[str, Any]]
    second: tuple[float, ...]
    first: float = 1.0
    links: bool = False


def _pd(axes: Sequence[Axis], w: float, ratio: float) -> dict[str, Any]:
    kp, kd = [w**2 * axis.whole for axis in axes], [2 * ratio * w * axis.whole for axis in axes]
    return {"kind": "pid", "kp": kp, "ki": 0.0, "kd": kd, "derivative_filter": FILTER}


def _pid(axes: Sequence[Axis], w: float, ratio: float) -> dict[str, Any]:
    return _pd(axes, w, ratio) | {"ki": [INTEGRAL * w**3 * axis.whole for axis in axes]}


def _computed_torque(axes: Sequence[Axis], w: float, ratio: float) -> dict[str, Any]:
    del axes
    return {"kind": "computed_torque", "kp": w**2, "kd": 2 * ratio * w, "speed_filter": FILTER}


def _static(axes: Sequence[Axis], w: float, filter_share: float) -> dict[str, Any]:
    del axes
    observer = {"kind": "differences", "speed_filter": FILTER * filter_share}
    return {"kind": "feedback_linearisation", "bandwidth": w, "observer": observer}


def _quasi_static(axes: Sequence[Axis], w: float, ratio: float) -> dict[str, Any]:
    del axes
    observer = {"kind": "differences", "speed_filter": FILTER}
    return {
        "kind": "quasi_static_linearisation", "bandwidth": w, "motor_bandwidth": ratio * w, "observer": observer
    }  # fmt: skip


def _states(axes: Sequence[Axis], w: float, weight: float) -> dict[str, Any]:
    gains = np.array([state_gains(axis, w, weight) for axis in axes]).T
    keys = ("motor_position", "motor_speed", "link_position", "link_speed")
    observer = {"kind": "differences", "speed_filter": FILTER}
    return {"kind": "state_feedback", **{key: row.tolist() for key, row in zip(keys, gains, strict=True)}} | {
        "observer": observer
    }


def _kalman(torque_noise: float) -> dict[str, Any]:
    return {"kind": "kalman", "torque_noise": torque_noise, "force_noise": 5.0 * torque_noise}


def _states_estimated(axes: Sequence[Axis], w: float, torque_noise: float) -> dict[str, Any]:
    return _states(axes, w, _CRITICAL) | {"observer": _kalman(torque_noise)}


def _static_estimated(axes: Sequence[Axis], w: float, torque_noise: float) -> dict[str, Any]:
    return _static(axes, w, 1.0) | {"observer": _kalman(torque_noise)}


def state_gains(axis: Axis, w: float, weight: float) -> FloatArray:
    """Design the state feedback of one axis by LQ: least integral of (J w^2 q_a)^2 + (weight J w q_a')^2 + u^2.

    J is the inertia of motor and link together, the other axes held. Were the gear rigid and without losses, the gain
    of the position would be J w^2, as of the PD controller. In the model the other axes are free, which keeps the
    coupled axes stable.

    Args:
        axis: The axis.
        w: Bandwidth [rad/s].
        weight: Weight of the speed [1].

    Returns:
        Gains of motor position, motor speed, link position and link speed, shape (4,).
    """
    k, d = axis.stiffness, axis.damping
    A = np.array(
        [
            [0.0, 1.0, 0.0, 0.0],
            [-k / axis.motor, -(d + axis.friction) / axis.motor, k / axis.motor, d / axis.motor],
            [0.0, 0.0, 0.0, 1.0],
            [k / axis.free, d / axis.free, -k / axis.free, -d / axis.free],
        ]
    )
    B = np.array([[0.0], [1.0 / axis.motor], [0.0], [0.0]])
    Q = np.diag([0.0, 0.0, w**4, (weight * w) ** 2])
    R = np.array([[1.0 / axis.whole**2]])
    return np.asarray(B.T @ solve_continuous_are(A, B, Q, R) / R[0, 0]).ravel()


_DAMPING = (0.3, 0.5, 0.7, 1.0, 1.4, 2.0, 3.0)
_CRITICAL = float(np.sqrt(2.0))
_RATIO = (0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0)
_NOISE = (0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0)
LAWS: tuple[Law, ...] = (
    Law("PD + rigid feedforward", "PD rigid", "PD of the motors; second number: damping ratio", "rigid", _pd, _DAMPING),
    Law("PD + DAE feedforward", "PD DAE", "PD of the motors; second number: damping ratio", "dae", _pd, _DAMPING),
    Law(
        "PID + DAE feedforward",
        "PID DAE",
        "PD with integral action; second number: damping ratio",
        "dae",
        _pid,
        _DAMPING,
    ),
    Law(
        "computed torque",
        "computed torque",
        "equation 5.3, rigid model in the loop; second number: damping ratio",
        "flexible_joint",
        _computed_torque,
        _DAMPING,
    ),
    Law(
        "static linearisation",
        "static",
        "equation 5.11, link encoders; second number: time constant of the differences [ms]",
        "flexible_joint",
        _static,
        (0.25, 0.5, 1.0, 2.0),
        links=True,
    ),
    Law(
        "quasi-static linearisation",
        "quasi-static",
        "link encoders; second number: bandwidth of the motors over that of the links",
        "flexible_joint",
        _quasi_static,
        _RATIO,
        links=True,
    ),
    Law(
        "feedforward + states",
        "states",
        "equation 5.12, link encoders, LQ design; second number: weight of the speed",
        "dae",
        _states,
        (0.5, 1.0, _CRITICAL, 2.0, 3.0, 5.0),
        first=_CRITICAL,
        links=True,
    ),
    Law(
        "static linearisation, estimated",
        "static est.",
        "equation 5.11 on motor encoders and a Kalman filter; second number: torque noise of its design [Nm]",
        "flexible_joint",
        _static_estimated,
        _NOISE,
        first=0.1,
    ),
    Law(
        "feedforward + states, estimated",
        "states est.",
        "equation 5.12 on motor encoders and a Kalman filter; second number: torque noise of its design [Nm]",
        "dae",
        _states_estimated,
        _NOISE,
        first=0.1,
    ),
)
"""The laws. Flexible-joint feedforward where the law needs references of links that belong to its own model."""
