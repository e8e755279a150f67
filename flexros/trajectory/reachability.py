"""Check that a robot can follow a tool trajectory: reach, singularities and configuration."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np

from flexros.errors import InputError
from flexros.trajectory.joint_derivatives import CONTINUATION_STEP, joint_derivatives

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.trajectory.joint_derivatives import OutputDerivatives
    from flexros.trajectory.trajectory import PathPoint, Trajectory

SMALLEST_SINGULAR_VALUE = 0.005
"""A point is singular if the Jacobian's smallest singular value is below this fraction of the largest so far (chosen).

The largest up to the point is used, because with one joint both values at the point itself are equal."""


class InverseKinematics(Protocol):
    """Gives the joint position of a tool point, nearest to a given one."""

    def __call__(self, target: FloatArray, near: FloatArray, /) -> FloatArray:
        """Solve for tool coordinates of shape (n_out,) near joints of shape (n_joints,); InputError if out of reach."""


class Jacobian(Protocol):
    """Gives the derivative of the tool coordinates with respect to the joints."""

    def __call__(self, joints: FloatArray, /) -> FloatArray:
        """Return the Jacobian at joints of shape (n_joints,), shape (n_out, n_joints)."""


@dataclass(frozen=True, eq=False)
class Reachability:
    """Joint motion on a trajectory that the robot can follow.

    Args:
        time: Checked times [s], shape (n,).
        joints: Joint positions [rad or m], shape (n, n_joints).
        smallest_singular_value: Smallest singular value of the Jacobian, relative to the largest up to there.
        nearest_singularity: Point of the smallest value.
    """

    time: FloatArray
    joints: FloatArray
    smallest_singular_value: float
    nearest_singularity: PathPoint


def check_reachable(
    trajectory: Trajectory,
    inverse_kinematics: InverseKinematics,
    jacobian: Jacobian,
    near: FloatArray,
    *,
    singular_value: float = SMALLEST_SINGULAR_VALUE,
    samples: int = 400,
) -> Reachability:
    """Check a trajectory point by point and refuse it at the first one that the robot cannot follow.

    Args:
        trajectory: Tool trajectory.
        inverse_kinematics: Joint position of a tool point, nearest to a given one.
        jacobian: Derivative of the tool coordinates at a joint position.
        near: Joint position near that of the start [rad or m], shape (n_joints,).
        singular_value: Smallest allowed singular value of the Jacobian, relative to its largest up to there.
        samples: Number of points on every move; repeated moves are checked once.

    Returns:
        Joint positions and distance to singularities.

    Raises:
        InputError: Out of reach, singular, or a jump to another configuration; the message names time, share of the
            path, path parameter and point.
    """
    time = trajectory.sample_times(samples)
    values = trajectory.evaluate(time, derivatives=1)
    joints: list[FloatArray] = []
    speeds: list[FloatArray] = []
    singular: list[float] = []
    largest = 1e-300
    for k, t in enumerate(time):
        q = _solve(trajectory, inverse_kinematics, float(t), values[0, k], joints[-1] if joints else near)
        slope = np.atleast_2d(np.asarray(jacobian(q), dtype=float))
        sizes = np.linalg.svd(slope, compute_uv=False)
        largest = max(largest, float(sizes[0]))
        singular.append(float(sizes[-1]) / largest)
        _check_regular(trajectory, float(t), singular[-1], singular_value)
        rate = np.linalg.lstsq(slope, values[1, k], rcond=None)[0]
        if joints:
            _check_same_configuration(
                trajectory, time[k - 1 : k + 1], joints[-1], q, np.maximum(abs(speeds[-1]), abs(rate))
            )
        joints.append(q)
        speeds.append(rate)
    nearest = int(np.argmin(singular))
    return Reachability(
        time=time,
        joints=np.array(joints),
        smallest_singular_value=float(singular[nearest]),
        nearest_singularity=trajectory.place(float(time[nearest])),
    )


def is_reachable(
    trajectory: Trajectory,
    kinematics: OutputDerivatives,
    near: FloatArray,
    *,
    singular_value: float = SMALLEST_SINGULAR_VALUE,
    samples: int = 400,
) -> bool:
    """Check a trajectory at all points at once, by the criteria of `check_reachable`.

    Args:
        trajectory: Tool trajectory.
        kinematics: Output function of as many joints as tool coordinates.
        near: Joint position near that of the start [rad or m], shape (n_joints,).
        singular_value: Smallest allowed singular value of the Jacobian, relative to its largest up to there.
        samples: Number of points on every move; repeated moves are checked once.

    Returns:
        Whether the robot can follow; False also where that shows only point by point, or no later in this way.
    """
    time = trajectory.sample_times(samples)
    if trajectory.duration > 0.5 * CONTINUATION_STEP * time.size:
        return False
    try:
        joints, speeds = joint_derivatives(trajectory, kinematics, near, time, 1)
    except InputError:
        return False
    sizes = np.linalg.svd(kinematics.value_slope(joints)[1], compute_uv=False)
    regular = sizes[:, -1] >= singular_value * np.maximum.accumulate(sizes[:, 0])
    fastest = np.maximum(np.abs(speeds[:-1]), np.abs(speeds[1:]))
    steps = np.abs(np.diff(joints, axis=0))
    return bool(np.all(regular) and np.all(steps <= _explained(fastest, np.diff(time)[:, None])))


def _explained(speed: FloatArray, duration: FloatArray | float) -> FloatArray:
    """Return the largest joint step that speeds explain [rad or m]."""
    return np.asarray(5.0 * speed * duration + 1e-2)


def _solve(
    trajectory: Trajectory, inverse_kinematics: InverseKinematics, t: float, target: FloatArray, near: FloatArray
) -> FloatArray:
    try:
        q = np.asarray(inverse_kinematics(target, near), dtype=float)
    except InputError as error:
        reason = str(error).rsplit(";", 1)[0]  # without its advice, which is for a single target
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


def _check_regular(trajectory: Trajectory, t: float, smallest: float, allowed: float) -> None:
    """Refuse a singular value that is too small relative to the largest one."""
    if smallest < allowed:
        raise InputError(
            f"the trajectory passes a singularity of the robot at {trajectory.place(t)}: the smallest singular value "
            f"of the Jacobian is {smallest:.3g} of the largest, allowed are at least {allowed:.3g}; move the path away "
            "from there"
        )


def _check_same_configuration(
    trajectory: Trajectory, times: FloatArray, before: FloatArray, q: FloatArray, speed: FloatArray
) -> None:
    """Refuse a joint step much larger than the joint speeds imply."""
    step = np.abs(q - before)
    explained = _explained(speed, float(times[1] - times[0]))
    if np.any(step > explained):
        joint = int(np.argmax(step / explained))
        raise InputError(
            f"the robot would jump to another configuration at {trajectory.place(float(times[1]))}: joint {joint + 1} "
            f"changes by {step[joint]:.3g} within {times[1] - times[0]:.3g} s, allowed is a continuous motion; move "
            "the path away from the singularity there or start in the other configuration"
        )
