"""Goal of the action FollowJointTrajectory: tolerances and outcome."""

from __future__ import annotations

import math
from enum import IntEnum
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np

from flexros.logs.stamps import NANOSECONDS
from flexros_nodes.protocol.reference.trajectory_request import RejectedTrajectoryError, Rejection

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from flexros.arrays import FloatArray


class Outcome(IntEnum):
    """Outcome of a goal: the values of error_code in control_msgs/action/FollowJointTrajectory."""

    SUCCESSFUL = 0
    INVALID_GOAL = -1
    INVALID_JOINTS = -2
    OLD_HEADER_TIMESTAMP = -3
    PATH_TOLERANCE_VIOLATED = -4
    GOAL_TOLERANCE_VIOLATED = -5


OUTCOME_OF_REASON = {
    Rejection.JOINTS: Outcome.INVALID_JOINTS,
    Rejection.POINTS: Outcome.INVALID_GOAL,
    Rejection.TOO_LATE: Outcome.OLD_HEADER_TIMESTAMP,
}


class Verdict(NamedTuple):
    """Outcome of a goal and its explanation, empty on success."""

    outcome: Outcome
    text: str = ""


class JointTolerance(Protocol):
    """Message control_msgs/msg/JointTolerance."""

    name: str
    position: float
    velocity: float
    acceleration: float


def position_tolerances(given: Iterable[JointTolerance], names: Sequence[str], field: str) -> FloatArray:
    """Decode position tolerances.

    Args:
        given: Tolerances by joint; 0 and -1 mean none.
        names: Joint names in the order of the motors.
        field: Field of the goal, for error messages.

    Returns:
        Largest distance from the reference [rad or m], shape (M,), infinite where there is no tolerance.

    Raises:
        RejectedTrajectoryError: A joint is unknown, a tolerance is not a number, or it limits an unmeasured quantity.
    """
    tolerances = np.full(len(names), np.inf)
    for tolerance in given:
        entry = f"{field} of {tolerance.name}"
        if tolerance.name not in names:
            raise RejectedTrajectoryError(f"{entry}: allowed are {', '.join(names)}", Rejection.JOINTS)
        if tolerance.velocity > 0.0 or tolerance.acceleration > 0.0:
            raise RejectedTrajectoryError(
                f"{entry} limits velocity or acceleration, allowed is position: only positions are measured",
                Rejection.POINTS,
            )
        position = tolerance.position
        if not math.isfinite(position) or (position < 0.0 and position != -1.0):
            raise RejectedTrajectoryError(
                f"{entry} is {position}, allowed is a number above 0; 0 or -1 for none", Rejection.POINTS
            )
        if position > 0.0:
            tolerances[names.index(tolerance.name)] = position
    return tolerances


def refuse_component_tolerances(given: Iterable[object], field: str) -> None:
    """Refuse tolerances of joints of several degrees of freedom, which belong to `multi_dof_trajectory`.

    Args:
        given: Tolerances by joint and component.
        field: Field of the goal, for error messages.

    Raises:
        RejectedTrajectoryError: There is one: to ignore it would call a motion good that the sender does not allow.
    """
    if names := [str(getattr(tolerance, "joint_name", "?")) for tolerance in given]:
        raise RejectedTrajectoryError(
            f"{field} limits components of {', '.join(names)}, but each joint of this robot has one: allowed are "
            f"tolerances in {field.removeprefix('component_')}",
            Rejection.POINTS,
        )


class TrajectoryGoal:
    """Evaluates a motion sample by sample.

    Until the last point the measured position must stay within the path tolerance of the reference. After it the goal
    is reached once the position is within the goal tolerance of the last point, at the latest after the goal time.

    Args:
        names: Joint names in the order of the motors.
        path: Path tolerance [rad or m], shape (M,).
        goal: Goal tolerance [rad or m], shape (M,).
        goal_time: Longest time after the last point [s]; unlimited where it is not above 0.
    """

    def __init__(self, names: Sequence[str], path: FloatArray, goal: FloatArray, goal_time: float) -> None:
        self._names = names
        self._path = path
        self._goal = goal
        self._goal_ns = goal_time * NANOSECONDS if goal_time > 0.0 else math.inf

    def evaluate(self, stamp: int, end: int, reference: FloatArray, measured: FloatArray) -> Verdict | None:
        """Evaluate a sample.

        Args:
            stamp: Its stamp [ns].
            end: Stamp of the last point [ns].
            reference: Reference position [rad or m], shape (M,).
            measured: Measured position [rad or m], shape (M,).

        Returns:
            Outcome of the goal; None while it is not decided.
        """
        distance = np.abs(measured - reference)
        if stamp < end:
            if not (distance > self._path).any():
                return None
            excess = self._largest_error(distance, self._path, stamp)
            return Verdict(Outcome.PATH_TOLERANCE_VIOLATED, f"{excess}; the robot comes to rest")
        if not (distance > self._goal).any():
            return Verdict(Outcome.SUCCESSFUL)
        if stamp - end <= self._goal_ns:
            return None
        late = f"{(stamp - end) / NANOSECONDS:g} s after the last point "
        return Verdict(Outcome.GOAL_TOLERANCE_VIOLATED, late + self._largest_error(distance, self._goal, stamp))

    def _largest_error(self, distance: FloatArray, tolerance: FloatArray, stamp: int) -> str:
        joint = int(np.argmax(distance / tolerance))
        return (
            f"{self._names[joint]} is {distance[joint]:.3g} from its reference at stamp {stamp / NANOSECONDS:.4f} s, "
            f"allowed is {tolerance[joint]:.3g}"
        )
