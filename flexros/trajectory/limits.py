"""Limits of a motion: along a path, of joints, and the check of a complete trajectory."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.trajectory.time_law import positive

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.trajectory.path import AbstractPath
    from flexros.trajectory.trajectory import Trajectory

LIMIT_NAMES = ("speed", "acceleration", "jerk", "snap")
"""First to fourth time derivative; snap is the derivative of the jerk."""


@dataclass(frozen=True)
class Limits:
    """Largest magnitudes of the time derivatives of a motion; infinite means no limit.

    Args:
        speed: [p/s] with p the unit of the coordinate: of the path parameter, m along the path, or rad of a joint.
        acceleration: [p/s^2].
        jerk: [p/s^3].
        snap: Derivative of the jerk [p/s^4].

    Raises:
        InputError: A limit is zero, negative or not a number.
    """

    speed: float = math.inf
    acceleration: float = math.inf
    jerk: float = math.inf
    snap: float = math.inf

    def __post_init__(self) -> None:
        for order, (name, value) in enumerate(zip(LIMIT_NAMES, self.values, strict=True), start=1):
            if value != math.inf:
                positive(value, f"{name} limit", f"(unit of the path)/s^{order}")

    @property
    def values(self) -> tuple[float, float, float, float]:
        """Speed, acceleration, jerk, snap."""
        return self.speed, self.acceleration, self.jerk, self.snap

    def along(self, path: AbstractPath) -> Limits:
        """Convert limits along the path [m/s, ...] to limits of its parameter [p/s, ...] by the arc length."""
        return Limits(*(value / path.pace for value in self.values))


def joint_limits(path: AbstractPath, limits: tuple[FloatArray, FloatArray, FloatArray, FloatArray]) -> Limits:
    """Convert limits of every joint to limits of the parameter of a joint path.

    Args:
        path: Path in joint space.
        limits: Speed, acceleration, jerk and snap of every joint [rad/s or m/s, ...], each of shape (n_joints,).

    Returns:
        The largest parameter limits with which every joint stays within its own on straight parts; in corners this
        holds for the speed only.

    Raises:
        InputError: A limit is zero, negative or not a number, or their number is not that of the joints.
    """
    pace = path.coordinate_pace
    converted = []
    for order, (name, values) in enumerate(zip(LIMIT_NAMES, limits, strict=True), start=1):
        given = np.broadcast_to(values, pace.shape) if np.ndim(values) == 0 or len(values) == 1 else np.asarray(values)
        if given.shape != pace.shape:
            raise InputError(
                f"there are {given.size} {name} limits for {pace.size} joints, allowed is one per joint or one number "
                "for all; correct the list"
            )
        for joint, value in enumerate(given, start=1):
            if value != math.inf:
                positive(float(value), f"{name} limit of joint {joint}", f"rad/s^{order} or m/s^{order}")
        moving = pace > 0.0
        converted.append(float(np.min(given[moving] / pace[moving])))
    return Limits(*converted)


def check_limits(trajectory: Trajectory, limits: Limits, samples: int = 2000) -> None:
    """Check the magnitude of the derivative vectors of a trajectory, including corners and centripetal components.

    Args:
        trajectory: The motion; checked are the positions of tool coordinates, or the joint with the largest value.
        limits: Allowed sizes [m/s, m/s^2, m/s^3, m/s^4], or of the joints.
        samples: Number of times on every move.

    Raises:
        InputError: A limit is exceeded; the message names quantity, point and the necessary slowdown.
    """
    bounded = [k for k, value in enumerate(limits.values, start=1) if value != math.inf]
    if not bounded:
        return
    time = trajectory.sample_times(samples)
    values = trajectory.evaluate(time, derivatives=max(bounded))
    for order in bounded:
        if trajectory.joints:
            size = np.max(np.abs(values[order]), axis=1)
        else:
            size = np.linalg.norm(values[order][:, :3], axis=1)
        worst = int(np.argmax(size))
        limit = limits.values[order - 1]
        if size[worst] > limit * (1.0 + 1e-9):
            unit = ("rad" if trajectory.joints else "m") + "/s" + (f"^{order}" if order > 1 else "")
            raise InputError(
                f"the {LIMIT_NAMES[order - 1]} reaches {size[worst]:.6g} {unit} at {trajectory.place(time[worst])}, "
                f"allowed are {limit:.6g} {unit} in all; slow the motion down by a factor "
                f"{(size[worst] / limit) ** (1.0 / order):.4g} or widen the zone or radius there"
            )
