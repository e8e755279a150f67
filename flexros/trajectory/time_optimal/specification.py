"""The time law `time_optimal` of a trajectory: its settings, and the moves planned with it."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Literal

import numpy as np
from pydantic import Field

from flexros.config.per_motor import PositivePerMotor, per_motor
from flexros.config.settings import Settings
from flexros.trajectory.time_optimal.planner import OptimalMove, optimal_move

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.trajectory.path import AbstractPath
    from flexros.trajectory.time_optimal.path_dynamics import ArmOnPath, PathDynamics


class TimeOptimalSpecification(Settings):
    """As fast along the path as torque and speed limits of the motors allow, smoothed."""

    type: Literal["time_optimal"]
    torque_limit: PositivePerMotor | None = Field(
        default=None, description="largest motor torque [Nm or N], one or one per motor; default: that of the robot"
    )
    torque_share: float = Field(
        default=1.0,
        gt=0.0,
        le=1.0,
        description="share of the torque limit that is planned [1]; the rest is for feedback",
    )
    speed_limit: PositivePerMotor | None = Field(
        default=None,
        description="largest speed of the gears [rad/s or m/s], one or one per motor; default: the robot's",
    )
    path_speed: float | None = Field(
        default=None, gt=0.0, description="largest speed along the path [m/s], joint moves: norm of the joints [rad/s]"
    )
    smoothing: float = Field(
        default=0.1,
        gt=0.0,
        le=10.0,
        description="least time over which a step of the acceleration is spread [s], doubled "
        "where that is faster; the jerk is at most the step of the acceleration divided by half of it",
    )
    points: int = Field(default=801, ge=11, le=20001, description="number of grid points on every path [1]")

    def plan(self, paths: Sequence[AbstractPath], arm: ArmOnPath, *, return_to_start: bool) -> list[OptimalMove]:
        """Plan the moves along successive paths, with a stop between them.

        Args:
            paths: The paths in order.
            arm: The robot.
            return_to_start: Whether the same paths are travelled back.

        Returns:
            The moves; the way back is planned by itself, because friction and gravity act otherwise.

        Raises:
            InputError: Out of reach, nothing limits the motion, or the limits leave no motion.
        """
        nears: list[FloatArray | None] = [None]
        for path in paths:
            nears.append(arm.end(path, nears[-1]))
        moves = [self._move(path, arm, near, None) for path, near in zip(paths, nears, strict=False)]
        if return_to_start:
            for path, begin, end in reversed(list(zip(paths, nears[:-1], nears[1:], strict=True))):
                moves.append(self._move(path, arm, begin, end))
        return moves

    def _move(
        self, path: AbstractPath, arm: ArmOnPath, begin: FloatArray | None, end: FloatArray | None
    ) -> OptimalMove:
        """Plan one move, backwards if the gear positions at the end of the path are given."""
        dynamics = self._limited(arm.dynamics(path, begin, self.points), path)
        return optimal_move(path, arm, dynamics, begin, end, smoothing=self.smoothing)

    def _limited(self, dynamics: PathDynamics, path: AbstractPath) -> PathDynamics:
        """Put the limits of the time law in the place of those of the robot."""
        n_motors = dynamics.n_motors
        upper, speed = dynamics.upper, dynamics.speed_limit
        if self.torque_limit is not None:
            upper = np.broadcast_to(per_motor("torque_limit of the time law", self.torque_limit, n_motors), upper.shape)
        if self.speed_limit is not None:
            speed = per_motor("speed_limit of the time law", self.speed_limit, n_motors)
        pace = np.inf if self.path_speed is None else self.path_speed / (path.pace * path.extent)
        upper = self.torque_share * upper
        return replace(dynamics, upper=upper, lower=-upper, speed_limit=speed, pace_limit=pace)
