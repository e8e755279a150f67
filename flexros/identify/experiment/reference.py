"""The reference of an identification experiment: moves by the feedforward, the excitation on top of its rests."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.feedforward.compensation.compensation import look_ahead
from flexros.feedforward.motion import Reference
from flexros.feedforward.reference import compute_reference
from flexros.identify.experiment.excursion import excursion
from flexros.identify.experiment.timetable import move_law
from flexros.trajectory import JOINTS, JointMove, Move, Rest, Trajectory
from flexros.trajectory.time_law import rest

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray, IntArray
    from flexros.effects import PlacedLaw
    from flexros.feedforward.specification import FeedforwardSpecification
    from flexros.identify.experiment.plan import ExperimentPlan
    from flexros.identify.experiment.timetable import Visit
    from flexros.robot import Robot

SETTLED = 1.0
"""Rest after a move that the feedforward computes, in addition to that of the plan [s] (chosen); then its torque is
held."""


def moves_of(plan: ExperimentPlan) -> Trajectory:
    """Return the moves from position to position, with rests just long enough for the feedforward to come to rest.

    Args:
        plan: The plan.

    Returns:
        Gear motion; every move with its rest takes whole samples.
    """
    moves, here = [], plan.start
    for visit in plan.visits:
        goal, time = plan.positions[visit.position], (_moving(visit, plan) - visit.begin) * plan.sample_time
        if np.array_equal(here, goal):
            moves.append(Move(Rest(goal), rest(time)))
        else:
            law = move_law(here, goal, plan.specification.move)
            moves.append(Move(JointMove(here, goal), law.held(after=time - law.duration)))
        here = goal
    return Trajectory(tuple(moves), JOINTS)


def identification_reference(
    plan: ExperimentPlan,
    robot: Robot,
    feedforward: FeedforwardSpecification,
    near: FloatArray | None = None,
    laws: Sequence[PlacedLaw] = (),
) -> Reference:
    """Compute the reference of the whole experiment.

    While the robot stays in a position the feedforward holds its torque, gravity load included, and the motors follow
    the position plus slow motion and excitation: the speed reference is exactly periodic, and the position reference is
    its exact integral. Tool pose and output are those of the position.

    Args:
        plan: The plan.
        robot: The robot as the feedforward knows it.
        feedforward: Method and settings of the feedforward.
        near: Arm coordinates near which the start pose is sought [rad or m], shape (N,); default: the home pose.
        laws: Laws of effects that the feedforward makes up for.

    Returns:
        The reference, plan.n_samples rows.

    Raises:
        InputError: Feedforward and robot do not go together.
    """
    rows = _rows(plan, look_ahead(robot, laws, plan.sample_time) + 1)
    moves = compute_reference(
        robot,
        moves_of(plan),
        feedforward,
        plan.sample_time,
        int(np.max(rows)) * plan.sample_time,
        near,
        laws,
    )
    position, velocity = moves.motor_position[rows], moves.motor_velocity[rows]
    for visit in plan.visits:
        added, where = excursion(plan, visit), slice(visit.lead, visit.end)
        position[where] += added.position
        velocity[where] += added.speed
    return Reference(
        time=np.arange(plan.n_samples, dtype=np.float64) * plan.sample_time,
        motor_position=position,
        motor_velocity=velocity,
        torque=moves.torque[rows],
        output=moves.output[rows],
        tool_pose=moves.tool_pose[rows],
    )


def _moving(visit: Visit, plan: ExperimentPlan) -> int:
    """Return the sample up to which the feedforward computes a move and its rest."""
    return min(visit.lead + round(SETTLED / plan.sample_time), visit.end)


def _rows(plan: ExperimentPlan, ahead: int) -> IntArray:
    """Return the row of the moves' reference that holds at every sample, shape (n_samples,).

    The last rows of a rest look `ahead` to the next move; the row before them is held during the stay.
    """
    rows, begin = np.empty(plan.n_samples, dtype=np.int64), 0
    for visit in plan.visits:
        computed = _moving(visit, plan) - visit.begin
        local = np.arange(visit.end - visit.begin)
        stays = visit.end - visit.begin - computed
        held = computed - 1 - ahead
        rows[visit.begin : visit.end] = begin + np.where(
            local <= held, local, np.where(local < held + stays, held, local - stays)
        )
        begin += computed
    rows[-1] = begin - 1 - ahead
    return rows
