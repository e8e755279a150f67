"""The key `trajectory` of a scenario: its settings, and the trajectory built from them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from pydantic import Field

from flexros.config.settings import Settings
from flexros.errors import InputError, source_named
from flexros.trajectory.limits import LIMIT_NAMES, Limits, check_limits
from flexros.trajectory.path import point, text
from flexros.trajectory.path_specification import JointMovesSpecification, PathSpecification
from flexros.trajectory.time_law_specification import TimeLawSpecification
from flexros.trajectory.time_optimal.planner import checked_together
from flexros.trajectory.time_optimal.specification import TimeOptimalSpecification
from flexros.trajectory.trajectory import JOINTS, Move, Trajectory

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike

    from flexros.trajectory.path import AbstractPath
    from flexros.trajectory.time_optimal.path_dynamics import ArmOnPath

CHECKED_CYCLES = 3
"""Number of repetitions of a time-optimal motion that are compared with the limits (chosen)."""

LONGEST = 3600.0
"""Longest trajectory [s] (chosen); a longer one indicates a wrong limit."""


class TotalLimits(Settings):
    """Limits of the whole motion, including corners and centripetal components; they are checked, not planned."""

    speed: float | None = Field(default=None, gt=0.0, description="largest speed [m/s], or of any joint [rad/s, m/s]")
    acceleration: float | None = Field(
        default=None, gt=0.0, description="largest acceleration [m/s^2], or of any joint [rad/s^2, m/s^2]"
    )
    jerk: float | None = Field(
        default=None, gt=0.0, description="largest jerk [m/s^3], or of any joint [rad/s^3, m/s^3]"
    )
    snap: float | None = Field(
        default=None, gt=0.0, description="largest derivative of the jerk [m/s^4], or of any joint [rad/s^4, m/s^4]"
    )

    @property
    def limits(self) -> Limits:
        """The limits that were given, infinite where none."""
        given = {name: getattr(self, name) for name in LIMIT_NAMES}
        return Limits(**{name: value for name, value in given.items() if value is not None})


class TrajectorySpecification(Settings):
    """A desired motion from the robot's start pose: path, time law, rests and repetitions.

    In a scenario, for example::

        trajectory:
          path: {type: circle, radius: 0.025, start_angle: 0, turns: 1}    # or centre_from_start: [-0.025, 0]
          time_law: {type: bang_bang_snap, speed: 0.5, acceleration: 15, jerk: 900, snap: 54000}
          hold_after: 0.1

        trajectory:
          path: {type: joint_moves, points: [[0.2, 0.3], [0.2, 0.6]], zone: 0.05}
          time_law: {type: ninth_degree, duration: 0.8}
          return_to_start: true
          repeat: 10
          dwell: 0.2
    """

    path: PathSpecification = Field(description="geometry: type line, circle, arc, lines or joint_moves, with its keys")
    time_law: TimeLawSpecification = Field(
        description="motion along the path: type quintic, ninth_degree, bang_bang_snap or time_optimal, with its keys"
    )
    output: str | None = Field(
        default=None,
        description="name of the robot's output that a tool path is for, e.g. tool; the controlled one when left out",
    )
    hold_before: float = Field(default=0.0, ge=0.0, description="rest at the start [s]")
    hold_after: float = Field(default=0.0, ge=0.0, description="rest at the end [s]")
    repeat: int = Field(default=1, ge=1, le=1000, description="number of cycles [1]; needs a path back to the start")
    dwell: float = Field(default=0.0, ge=0.0, description="rest at every stop between moves and between cycles [s]")
    return_to_start: bool = Field(default=False, description="go back the same way in the same manner")
    total_limits: TotalLimits | None = Field(
        default=None, description="limits of the whole motion to check (the time law's hold along the path)"
    )

    @property
    def joints(self) -> bool:
        """Whether the path is in joint space, so that its start is given in joint positions."""
        return isinstance(self.path, JointMovesSpecification)

    def output_of(self, controlled: str) -> str:
        """Return the name of the output in which the trajectory is defined.

        Args:
            controlled: Name of the robot's controlled output.

        Returns:
            "joints" for joint moves, else the key `output`, else the controlled output.
        """
        return JOINTS if self.joints else self.output or controlled


def build_trajectory(
    specification: TrajectorySpecification,
    start: ArrayLike,
    *,
    output: str = "tool",
    n_position: int | None = None,
    arm: ArmOnPath | None = None,
    source: str = "trajectory",
) -> Trajectory:
    """Build the trajectory of a specification.

    Args:
        specification: Settings of the trajectory.
        start: Start of the motion: tool coordinates [m, then rad], or joint positions [rad or m] if
            `specification.joints`, shape (n_out,). With six tool coordinates the last are roll, pitch, yaw.
        output: Name of the robot's output whose coordinates these are; joint moves are labelled "joints".
        n_position: Number of leading coordinates that are positions; default: all, at most 3.
        arm: The robot, for the time law time_optimal.
        source: Source of the specification; error messages begin with it.

    Returns:
        The trajectory.

    Raises:
        InputError: Impossible geometry, limits that cannot be met, a repetition of an open path, a motion of more than
            an hour, a path for another output than that of the start, or a time-optimal motion without a robot.
    """
    with source_named(f"{source}.path"):
        if output == JOINTS and not specification.joints:
            raise InputError(
                f"the path type {specification.path.type} moves the tool but the output is '{JOINTS}', allowed is an "
                "output with tool coordinates; set the key output of the trajectory, e.g. to tool, or use joint_moves"
            )
        if specification.output not in (None, output) and not specification.joints:
            raise InputError(
                f"the trajectory is for output '{specification.output}' but the start belongs to output '{output}', "
                "allowed are equal names; change the key output of the trajectory or that of the run"
            )
        origin = point(start, "start of the trajectory").copy()
        positions = min(3, origin.size) if n_position is None else n_position
        paths = specification.path.paths(origin, positions)
    with source_named(f"{source}.time_law"):
        cycle = _moves(specification, paths, arm)
    with source_named(source):
        trajectory = Trajectory(
            _repeated(specification, cycle, specification.repeat), JOINTS if specification.joints else output
        )
        if trajectory.duration > LONGEST:
            raise InputError(
                f"the trajectory lasts {trajectory.duration:.4g} s, allowed are at most {LONGEST:g} s; raise the "
                "limits of the time law or shorten duration, holds or repeat"
            )
        if specification.total_limits is not None:
            check_limits(trajectory, specification.total_limits.limits)
    return trajectory


def _moves(specification: TrajectorySpecification, paths: Sequence[AbstractPath], arm: ArmOnPath | None) -> list[Move]:
    """Return the moves along the paths, and back where the specification says so."""
    law = specification.time_law
    if isinstance(law, TimeOptimalSpecification):
        if arm is None:
            raise InputError(
                "the time law time_optimal depends on the torques of a robot, but none was given; give the robot (arm) "
                "or choose ninth_degree or bang_bang_snap"
            )
        planned = law.plan(paths, arm, return_to_start=specification.return_to_start)
        repeat = min(specification.repeat, CHECKED_CYCLES)
        return checked_together(planned, arm, lambda moves: _repeated(specification, moves, repeat))
    cycle = [Move(path, law.law(path, specification.joints)) for path in paths]
    if specification.return_to_start:
        cycle += [Move(move.path, move.law.mirrored()) for move in reversed(cycle)]
    return cycle


def _repeated(specification: TrajectorySpecification, cycle: list[Move], repeat: int) -> tuple[Move, ...]:
    """Return successive cycles, with rests before, between and after them."""
    begin = cycle[0].path.point_at(cycle[0].law.start)
    end = cycle[-1].path.point_at(cycle[-1].law.end)
    if specification.repeat > 1 and not np.allclose(begin, end, rtol=1e-9, atol=1e-9):
        raise InputError(
            f"the trajectory has repeat {specification.repeat} but its path begins at {text(begin)} and ends at "
            f"{text(end)}, allowed is to repeat a path that ends where it begins; set return_to_start: true or "
            "repeat: 1"
        )
    later = [Move(move.path, move.law.held(before=specification.dwell)) for move in cycle]
    moves = [Move(cycle[0].path, cycle[0].law.held(before=specification.hold_before)), *later[1:]]
    moves += later * (repeat - 1)
    moves[-1] = Move(moves[-1].path, moves[-1].law.held(after=specification.hold_after))
    return tuple(moves)
