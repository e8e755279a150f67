"""The arm on a path, as the planner of time-optimal motions sees it: rigid dynamics, and torque of the feedforward."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from flexros.feedforward.compensation.compensation import laws_of_the_arm
from flexros.feedforward.problem import FeedforwardProblem
from flexros.feedforward.reference import compute_reference, pre_actuation
from flexros.feedforward.rigid_arm import RigidArm
from flexros.feedforward.specification import FeedforwardSpecification
from flexros.trajectory.time_law import TimeLaw
from flexros.trajectory.time_optimal.path_dynamics import Demand, PathDynamics, path_grid
from flexros.trajectory.trajectory import Move, Trajectory

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.effects import PlacedLaw
    from flexros.robot import Robot
    from flexros.trajectory.path import AbstractPath

DERIVATIVES = 2
"""Highest derivative by the path that the rigid dynamics need."""


@dataclass(frozen=True, eq=False)
class FeedforwardOnPath:
    """Dynamics and feedforward torques of a robot on paths of one output; see `ArmOnPath`.

    Attributes:
        robot: The model that the feedforward uses.
        specification: Method and settings of the feedforward; the method none counts as rigid.
        sample_time: Sample time of the feedback [s].
        output: Output that the paths are for, or "joints".
        near: Arm coordinates near the start of the first path [rad or m], shape (N,); None: the home pose.
        laws: Laws of effects that the feedforward compensates.
    """

    robot: Robot
    specification: FeedforwardSpecification
    sample_time: float
    output: str
    near: FloatArray | None = None
    laws: tuple[PlacedLaw, ...] = ()
    _without_lead: set[tuple[AbstractPath, ...]] = field(default_factory=set, init=False, repr=False)

    def dynamics(self, path: AbstractPath, near: FloatArray | None, points: int) -> PathDynamics:
        """See `ArmOnPath.dynamics`."""
        grid = path_grid(points)
        position, slope, curvature = self._gears(path, near, DERIVATIVES, grid)
        arm = RigidArm(self.robot, laws_of_the_arm(self.laws))

        def torque(pace: float, acceleration: float) -> FloatArray:
            return arm.inverse_dynamics(
                np.array([position, pace * slope, acceleration * slope + pace**2 * curvature])
            ).torque

        static, ahead, back = torque(0.0, 0.0), torque(1.0, 0.0), torque(-1.0, 0.0)
        upper = np.broadcast_to(self.robot.torque_limits, static.shape)
        return PathDynamics(
            grid=grid,
            slope=slope,
            inertia=torque(0.0, 1.0) - static,
            centrifugal=0.5 * (ahead + back) - static,
            viscous=0.5 * (ahead - back),
            static=static,
            lower=-upper,
            upper=upper,
            speed_limit=self.robot.speed_limits,
            names=self.robot.joint_names,
        )

    def end(self, path: AbstractPath, near: FloatArray | None) -> FloatArray:
        """See `ArmOnPath.end`."""
        return np.asarray(self._gears(path, near, 0, np.array([0.0, 1.0]))[0, -1])

    def demand(self, moves: Sequence[Move], near: FloatArray | None) -> Demand:
        """See `ArmOnPath.demand`."""
        specification = self.specification
        if specification.method == "none":
            specification = FeedforwardSpecification(method="rigid", friction=specification.friction)
        trajectory = Trajectory(tuple(moves), self.output)
        start, paths, lead = self._arm(near), tuple(move.path for move in moves), 0.0
        if paths in self._without_lead:  # the zero dynamics depend on the poses of the path, not on the time law
            specification = specification.model_copy(update={"zero_dynamics_poses": 1})
        else:
            lead = pre_actuation(self.robot, trajectory, specification, self.sample_time, start, self.laws)
            if lead == 0.0:
                self._without_lead.add(paths)
        lead = max(0.0, lead - trajectory.rest_before)
        trajectory = trajectory.delayed(lead) if lead > 0.0 else trajectory
        reference = compute_reference(
            self.robot,
            trajectory,
            specification,
            self.sample_time,
            trajectory.duration,
            start,
            self.laws,
            link_motion=True,
        )
        return Demand(reference.time - lead, reference.torque, reference.link_motion[:, 1])

    def _gears(self, path: AbstractPath, near: FloatArray | None, derivatives: int, share: FloatArray) -> FloatArray:
        """Return gear positions and their derivatives by the share of the path, shape (derivatives + 1, n, M)."""
        steady = TimeLaw(
            knots=np.array([0.0, 1.0 + 1e-9]),  # the end itself belongs to the motion
            origins=np.zeros(1),
            coefficients=np.array([[0.0, path.extent]]),
            start=0.0,
            end=path.extent,
            bounded_derivatives=4,
            name="steady",
        )
        trajectory = Trajectory((Move(path, steady),), self.output)
        problem = FeedforwardProblem(
            self.robot,
            trajectory,
            self.specification,
            self.sample_time,
            share.size,
            self._arm(near),
            laws_of_the_arm(self.laws),
        )
        return problem.gear_motion(derivatives, share)

    def _arm(self, gears: FloatArray | None) -> FloatArray | None:
        return self.near if gears is None else np.asarray(self.robot.arm_from_gears(gears))
