"""Whether a robot can follow a trajectory: reach, singularities, joint speeds and ranges."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np

from flexros.errors import InputError

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.trajectory.trajectory import Place, Trajectory

SMALLEST_SINGULAR_VALUE = 0.01
"""A place is singular if the Jacobian's smallest singular value is below this [output per joint unit] (chosen)."""


class InverseKinematics(Protocol):
    """Gives the joint position of a tool point, nearest to a given one."""

    def __call__(self, target: FloatArray, near: FloatArray, /) -> FloatArray:
        """Solve for tool coordinates of shape (n_out,) near joints of shape (n_joints,); InputError if out of reach."""


class Jacobian(Protocol):
    """Gives the derivative of the tool coordinates with respect to the joints."""

    def __call__(self, joints: FloatArray, /) -> FloatArray:
        """Give the Jacobian at joints of shape (n_joints,), shape (n_out, n_joints)."""


@dataclass(frozen=True, eq=False)
class Reachability:
    """What a robot does on a trajectory that it can follow.

    Args:
        time: Times walked [s], shape (n,).
        joints: Joint positions [rad or m], shape (n, n_joints).
        smallest_singular_value: Smallest of the Jacobian on the way; infinite for joint trajectories.
        nearest_singularity: Where that is.
        peak_speed: Largest speed of every joint [rad/s or m/s], shape (n_joints,).
    """

    time: FloatArray
    joints: FloatArray
    smallest_singular_value: float
    nearest_singularity: Place
    peak_speed: FloatArray


def check_reachable(
    trajectory: Trajectory,
    inverse_kinematics: InverseKinematics,
    jacobian: Jacobian,
    near: FloatArray,
    *,
    speed_limits: FloatArray | None = None,
    joint_range: tuple[FloatArray, FloatArray] | None = None,
    singular_value: float = SMALLEST_SINGULAR_VALUE,
    samples: int = 400,
) -> Reachability:
    """Walk along a trajectory and refuse it at the first place where the robot cannot follow.

    Args:
        trajectory: Tool trajectory, or joint trajectory (of which only speeds and ranges are checked).
        inverse_kinematics: Joint position of a tool point, nearest to a given one.
        jacobian: Derivative of the tool coordinates at a joint position.
        near: Joint position near that of the start [rad or m], shape (n_joints,).
        speed_limits: Largest speed of every joint [rad/s or m/s], shape (n_joints,); None for no limit.
        joint_range: Smallest and largest joint positions [rad or m], each of shape (n_joints,); None for no limit.
        singular_value: Smallest allowed singular value of the Jacobian.
        samples: Number of places on every move; moves that repeat are walked once.

    Returns:
        Joint positions on the way and how near to a singularity they come.

    Raises:
        InputError: Out of reach, singular, a jump to another configuration, too fast, or out of the joints' range; the
            message names time, share of the path, path parameter and point.
    """
    time = trajectory.sample_times(samples)
    values = trajectory.evaluate(time, derivatives=1)
    joints: list[FloatArray] = []
    speeds: list[FloatArray] = []
    singular: list[float] = []
    for k, t in enumerate(time):
        if trajectory.joints:
            q, rate, smallest = values[0, k], values[1, k], np.inf
        else:
            q = _solve(trajectory, inverse_kinematics, float(t), values[0, k], joints[-1] if joints else near)
            slope = np.atleast_2d(np.asarray(jacobian(q), dtype=float))
            smallest = _smallest_singular_value(trajectory, float(t), slope, singular_value)
            rate = np.linalg.lstsq(slope, values[1, k], rcond=None)[0]
            if joints:
                _check_same_configuration(
                    trajectory, time[k - 1 : k + 1], joints[-1], q, np.maximum(abs(speeds[-1]), abs(rate))
                )
        _check_joints(trajectory, float(t), q, rate, speed_limits, joint_range)
        joints.append(q)
        speeds.append(rate)
        singular.append(smallest)
    nearest = int(np.argmin(singular))
    return Reachability(
        time=time,
        joints=np.array(joints),
        smallest_singular_value=float(singular[nearest]),
        nearest_singularity=trajectory.place(float(time[nearest])),
        peak_speed=np.max(np.abs(speeds), axis=0),
    )


def _solve(
    trajectory: Trajectory, inverse_kinematics: InverseKinematics, t: float, target: FloatArray, near: FloatArray
) -> FloatArray:
    try:
        q = np.asarray(inverse_kinematics(target, near), dtype=float)
    except InputError as error:
        reason = str(error).rsplit(";", 1)[0]  # its own advice, to move the target, is of no use within a trajectory
        raise InputError(
            f"the trajectory is out of reach at {trajectory.place(t)}: {reason}; move the start, turn the path or "
            "make it smaller"
        ) from error
    if not np.all(np.isfinite(q)):
        raise InputError(
            f"the trajectory is out of reach at {trajectory.place(t)}: the inverse kinematics has no finite solution; "
            "move the start, turn the path or make it smaller"
        )
    return q


def _smallest_singular_value(trajectory: Trajectory, t: float, slope: FloatArray, allowed: float) -> float:
    """Give the smallest singular value of a Jacobian, and refuse one that is too small."""
    smallest = float(np.linalg.svd(slope, compute_uv=False)[-1])
    if smallest < allowed:
        raise InputError(
            f"the trajectory passes a singularity of the robot at {trajectory.place(t)}: the smallest singular value "
            f"of the Jacobian is {smallest:.3g}, allowed are at least {allowed:.3g}; move the path away from there"
        )
    return smallest


def _check_same_configuration(
    trajectory: Trajectory, times: FloatArray, before: FloatArray, q: FloatArray, speed: FloatArray
) -> None:
    """Refuse a step of the joints much larger than their speeds explain."""
    step = np.abs(q - before)
    explained = 5.0 * speed * float(times[1] - times[0]) + 1e-2
    if np.any(step > explained):
        joint = int(np.argmax(step / explained))
        raise InputError(
            f"the robot would jump to another configuration at {trajectory.place(float(times[1]))}: joint {joint + 1} "
            f"changes by {step[joint]:.3g} within {times[1] - times[0]:.3g} s, allowed is a continuous motion; move "
            "the path away from the singularity there or start in the other configuration"
        )


def _check_joints(
    trajectory: Trajectory,
    t: float,
    q: FloatArray,
    rate: FloatArray,
    speed_limits: FloatArray | None,
    joint_range: tuple[FloatArray, FloatArray] | None,
) -> None:
    """Refuse a joint that is too fast or out of its range."""
    if speed_limits is not None and np.any(np.abs(rate) > np.asarray(speed_limits) * (1.0 + 1e-9)):
        joint = int(np.argmax(np.abs(rate) / speed_limits))
        raise InputError(
            f"joint {joint + 1} would move at {abs(rate[joint]):.4g} rad/s (or m/s) at {trajectory.place(t)}, "
            f"allowed are {np.asarray(speed_limits)[joint]:.4g}; lower the speed of the time law or move the path"
        )
    if joint_range is not None:
        lower, upper = (np.asarray(bound, dtype=float) for bound in joint_range)
        outside = np.maximum(lower - q, q - upper)
        joint = int(np.argmax(outside))
        if outside[joint] > 1e-9:
            raise InputError(
                f"joint {joint + 1} would be at {q[joint]:.4g} rad (or m) at {trajectory.place(t)}, allowed are "
                f"{lower[joint]:.4g} to {upper[joint]:.4g}; move the path"
            )
