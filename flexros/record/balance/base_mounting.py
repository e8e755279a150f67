"""Direction of gravity that torques show: a base on a wall, under a ceiling or at a slant, or a turned base frame.

The torque of a rigid arm is linear in the vector of gravity. It is fitted to the torques of all motors that move,
beside what every motor has of its own: an offset, both frictions and a rotor.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.record.balance.inverse_dynamics import rigid_inverse_dynamics
from flexros.record.balance.regression import coefficients

if TYPE_CHECKING:
    from flexros.arrays import BoolArray, FloatArray
    from flexros.robot import Robot

STANDARD = 9.81
"""Size of gravity where a robot file has none [m/s2]."""

CARRIES = 0.5
"""Change of the weight that a motor carries over its torque, both rms without their means, from which the weight shows
in it (chosen)."""

FEWEST = 2
"""Fewest motors that carry weight (chosen): of a single one, the zero of its position may as well be elsewhere."""

LOST = 0.3
"""Least rest of the torques with the stated direction, over the torques, both rms [1] (chosen): what a slant of the
base of about 17 deg leaves. Less is an error of the model, to be diagnosed."""

LESS = 0.4
"""Largest rest with the found direction, over that with the stated one [1] (chosen): wrong masses, centres of mass and
loads leave more, whatever the direction."""

LIGHTEST, HEAVIEST = 0.5, 2.0
"""Smallest and largest size of the gravity that is found, over that which is stated (chosen): masses may be off by as
much, and torques without the weight show none at all."""

IN_LINE = 5.0
"""Largest angle to an axis of the base up to which gravity counts as along it [deg] (chosen)."""

AS_WELL = 1.25
"""Largest rest with the zero of one joint elsewhere, over that with the found direction, from which both may be [1]
(chosen)."""

RIGHT_ANGLES = (90.0, -90.0, 180.0)
"""Differences between the zeros of two models of a robot that are tried [deg]."""

WORKS_AGAINST = -0.01
"""Power of the fitted friction over that of the torque, sizes in rms, below which friction would drive the motion
(chosen): torques of the other sign imitate a base upside down so."""


@dataclass(frozen=True, eq=False)
class BaseMounting:
    """Another direction of gravity that explains the torques far better.

    Attributes:
        gravity: Gravity in the frame of the base, of the stated size [m/s2], shape (3,).
        carrying: Motors that show it, shape (M,).
        stated: Rest of their torques with the stated direction, of any size, over the torques, in rms [1].
        found: The same with the found one.
        zeros: Joints and angles by which their zero may be elsewhere instead [deg].
    """

    gravity: FloatArray
    carrying: BoolArray
    stated: float
    found: float
    zeros: tuple[tuple[int, float], ...]


@dataclass(frozen=True, eq=False)
class _Motion:
    """Motion and torques of the motors at the valid samples, and the sample time of the whole."""

    robot: Robot
    position: FloatArray
    valid: BoolArray
    own: FloatArray
    torque: FloatArray
    moves: BoolArray
    sample_time: float
    highest: float


def base_mounting(
    robot: Robot,
    position: FloatArray,
    motion: FloatArray,
    torque: FloatArray,
    valid: BoolArray,
    moves: BoolArray,
    sample_time: float,
    highest: float,
) -> BaseMounting | None:
    """Find another direction of gravity that explains torques far better than the stated one.

    Args:
        robot: The nominal robot.
        position: Motor positions without holes [rad or m], shape (n, M).
        motion: Smooth positions, speeds and accelerations, shape (3, n, M).
        torque: Torques [Nm or N], shape (n, M).
        valid: Samples that count, shape (n,).
        moves: Motors that move, shape (M,).
        sample_time: Time between two samples [s].
        highest: Frequency up to which the torque of the arm is required [Hz].

    Returns:
        The direction; None where the stated one explains as much, or where it is none of gravity.
    """
    stated = np.array(robot.spec.gravity.value, dtype=float)
    size = float(np.linalg.norm(stated)) or STANDARD
    seen = _Motion(robot, position, valid, motion[1:, valid], torque[valid], moves, sample_time, highest)
    rests, weights = _own_removed(seen)
    if not rests.size:
        return None
    solution = coefficients(weights.reshape(-1, 3), rests.ravel())
    length = float(np.linalg.norm(solution))
    if not LIGHTEST * size < length < HEAVIEST * size:
        return None
    carried = np.zeros(len(moves))
    carried[moves] = np.std(weights @ solution, axis=1)
    carrying = moves & (carried > CARRIES)
    if carrying.sum() < FEWEST:
        return None
    chosen = carrying[moves]
    left = _rms(rests[chosen] - weights[chosen] @ solution)
    along = weights[chosen] @ stated
    scale = max(float(np.vdot(along, rests[chosen]) / max(float(np.vdot(along, along)), 1e-300)), 0.0)
    before = _rms(rests[chosen] - scale * along)
    if before < LOST or left > LESS * before or _drives(seen, carrying, solution):
        return None
    return BaseMounting(
        size * _in_line(solution / length), carrying, before, left, _zeros_elsewhere(seen, carrying, AS_WELL * left)
    )


def _own_removed(seen: _Motion, turned: FloatArray | None = None) -> tuple[FloatArray, FloatArray]:
    """Return torques and weights per gravity without what each motor has of its own, over the size of the torque.

    Args:
        seen: Motion and torques.
        turned: Angles that are added to the positions [rad], shape (M,); default: none.

    Returns:
        Torque without that of the bodies [1], shape (K, n) of the motors that move, and the weight by gravity along
        each axis [s2/m], shape (K, n, 3).
    """
    position = seen.position if turned is None else seen.position + turned

    def torques(gravity: FloatArray) -> FloatArray:
        values = dict(zip(("gravity.x", "gravity.y", "gravity.z"), gravity.tolist(), strict=True))
        robot = seen.robot.with_values(values)
        return rigid_inverse_dynamics(robot, position, seen.sample_time, seen.highest)[seen.valid]

    bodies = torques(np.zeros(3))
    weight = np.stack([torques(axis) - bodies for axis in np.eye(3)], axis=2)
    rests, weights = [], []
    for motor in np.flatnonzero(seen.moves):
        size = max(float(np.std(seen.torque[:, motor])), 1e-300)
        columns = np.column_stack([(seen.torque - bodies)[:, motor], weight[:, motor]]) / size
        own = _own(seen, int(motor))
        columns = columns - own @ np.column_stack([coefficients(own, column) for column in columns.T])
        rests.append(columns[:, 0])
        weights.append(columns[:, 1:])
    return np.array(rests), np.array(weights)


def _own(seen: _Motion, motor: int) -> FloatArray:
    """Return offset, speed, its sign and acceleration of a motor, shape (n, 4)."""
    speed, acceleration = seen.own[:, :, motor]
    return np.column_stack([np.ones_like(speed), speed, np.sign(speed), acceleration])


def _drives(seen: _Motion, carrying: BoolArray, gravity: FloatArray) -> bool:
    """Return whether friction beside the weight would drive the motion, as where torques have the other sign."""
    values = dict(zip(("gravity.x", "gravity.y", "gravity.z"), gravity.tolist(), strict=True))
    arm = rigid_inverse_dynamics(seen.robot.with_values(values), seen.position, seen.sample_time, seen.highest)
    for motor in np.flatnonzero(carrying):
        own = _own(seen, int(motor))
        torque = seen.torque[:, motor] - arm[seen.valid, motor]
        friction = own[:, 1:3] @ coefficients(own, torque)[1:3]
        sizes = np.std(seen.torque[:, motor]) * np.std(own[:, 1])
        if float(np.mean(friction * own[:, 1])) < WORKS_AGAINST * sizes:
            return True
    return False


def _zeros_elsewhere(seen: _Motion, carrying: BoolArray, most: float) -> tuple[tuple[int, float], ...]:
    """Return joints whose zero, elsewhere by a right angle, leaves no more of the torques with gravity as stated."""
    stated = np.array(seen.robot.spec.gravity.value, dtype=float)
    found = []
    for joint, motor in enumerate(seen.robot.motors):
        for angle in RIGHT_ANGLES if motor.position_unit == "rad" and np.any(stated) else ():
            turned = np.zeros(len(carrying))
            turned[joint] = np.radians(angle)
            rests, weights = _own_removed(seen, turned)
            chosen = carrying[seen.moves]
            if _rms(rests[chosen] - weights[chosen] @ stated) <= most:
                found.append((joint, angle))
    return tuple(found)


def _in_line(direction: FloatArray) -> FloatArray:
    """Return the axis of the base that a direction is close to, else the direction."""
    axis = int(np.argmax(np.abs(direction)))
    if abs(direction[axis]) < np.cos(np.radians(IN_LINE)):
        return direction
    return np.asarray(np.sign(direction[axis]) * np.eye(3)[axis])


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))
