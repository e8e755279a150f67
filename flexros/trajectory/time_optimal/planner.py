"""Time-optimal move along a path: fastest profile, smoothed, with the torques of the feedforward within the limits."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.errors import InputError
from flexros.trajectory.time_optimal.profile import FastestProfile, fastest_profile
from flexros.trajectory.time_optimal.smoothing import reversed_way, slowed, smoothed_law
from flexros.trajectory.trajectory import Move

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from flexros.arrays import FloatArray
    from flexros.trajectory.path import AbstractPath
    from flexros.trajectory.time_law import TimeLaw
    from flexros.trajectory.time_optimal.path_dynamics import ArmOnPath, PathDynamics

TOLERANCE = 1e-3
"""Excess over a limit, relative to it, that is accepted after smoothing (chosen)."""

ROUNDS = 12
"""Largest number of laws that are tried with tightened limits (chosen)."""

WORSE = 3
"""Number of laws without a gain after which no further one is tried (chosen)."""

SLOWEST = 10.0
"""Largest factor by which a move is slowed down (chosen)."""


@dataclass(frozen=True, eq=False)
class OptimalMove:
    """A time-optimal move and what it was made from.

    Attributes:
        move: Path and smooth time law.
        profile: The fastest motion of the rigid arm, with jumps of the acceleration.
        dynamics: Torques and limits of the rigid arm on the path.
        smoothing: Time over which a step of the acceleration is spread [s].
        rounds: Number of limits that were tried.
        slower_by: Factor by which the last one was slowed down, 1 for none.
        excess: Largest excess of a torque or speed over its limit, relative to the limit; 0 or less for none.
    """

    move: Move
    profile: FastestProfile
    dynamics: PathDynamics
    smoothing: float
    rounds: int
    slower_by: float
    excess: float

    @property
    def least_duration(self) -> float:
        """Duration of the fastest motion of the rigid arm [s]."""
        return self.profile.duration

    @property
    def duration(self) -> float:
        """Duration of the smooth motion [s]."""
        return self.move.law.duration

    def limiting(self) -> dict[str, float]:
        """Return for which share of the time of the fastest motion each torque, or some speed, is at its limit [1]."""
        reached = self.profile.use(self.dynamics) > 1.0 - TOLERANCE
        width = np.diff(self.profile.time) / self.profile.duration
        shares = width @ reached
        return dict(zip((*self.dynamics.names, "speed"), shares.tolist(), strict=True))

    def summary(self) -> dict[str, Any]:
        """Return the figures of the move for JSON."""
        return {
            "rigid_duration_s": self.least_duration,
            "duration_s": self.duration,
            "at_limit": self.limiting(),
            "smoothing_s": self.smoothing,
            "slowed_by": self.slower_by,
            "excess": self.excess,
        }


def optimal_move(
    path: AbstractPath,
    arm: ArmOnPath,
    dynamics: PathDynamics,
    begin: FloatArray | None,
    end: FloatArray | None = None,
    *,
    smoothing: float,
) -> OptimalMove:
    """Plan the fastest smooth move along a path.

    The fastest profile of the rigid arm is smoothed (`smoothed_law`), and the torques that the feedforward commands for
    it are compared with the limits. Where they exceed them, the smoothing time is doubled as long as this makes the
    move faster; then the limits of the profile are tightened by the excess, and the profile is found anew. The law that
    is fastest after what is left of the excess is removed by slowing the whole move down is taken.

    Args:
        path: The path.
        arm: The robot.
        dynamics: Its torques and limits on the path, from the start of the path to its end.
        begin: Gear positions near those at the start of the path [rad or m], shape (M,); None: those of the run.
        end: Gear positions at the end of the path [rad or m], shape (M,): the path is travelled backwards; None:
            forwards.
        smoothing: Least time over which a step of the acceleration is spread [s], above 0.

    Returns:
        The move.

    Raises:
        InputError: Nothing limits the motion, or the limits leave no motion.
    """
    backwards = end is not None
    near = end if backwards else begin
    dynamics = dynamics.backwards() if backwards else dynamics
    profile = fastest_profile(dynamics)
    tasks = _smooth_enough(_Task(path, arm, near, dynamics, smoothing, backwards), profile)
    return min((_within_limits(task, trial, profile) for task, trial in tasks), key=lambda move: move.duration)


def _smooth_enough(task: _Task, profile: FastestProfile) -> list[tuple[_Task, _Trial]]:
    """Double the smoothing time as long as limits are exceeded and the slower law that they ask for gets faster.

    Returns:
        The last two, or the first alone.
    """
    tried = [(task, task.tried(task.law(profile)))]
    while tried[-1][1].excess > TOLERANCE:
        longer = replace(task, smoothing=2.0 * tried[-1][0].smoothing)
        trial = longer.tried(longer.law(profile))
        if trial.estimate >= tried[-1][1].estimate:
            break
        tried.append((longer, trial))
    return tried[-2:]


def _within_limits(task: _Task, first: _Trial, profile: FastestProfile) -> OptimalMove:
    """Tighten the limits of the profile until the smooth law keeps them, and slow down what is left of the excess."""
    tight, tight_profile, best, trials = task.dynamics, profile, first, [first]
    while trials[-1].excess > TOLERANCE and len(trials) < ROUNDS and len(trials) - trials.index(best) <= WORSE:
        tight = _tightened(tight, task.dynamics, tight_profile, trials[-1], task.smoothing)
        try:
            tight_profile = fastest_profile(tight)
        except InputError:  # tightened to a standstill somewhere on the path; the best law so far is slowed down
            break
        trials.append(task.tried(task.law(tight_profile)))
        best = min(trials, key=lambda each: each.estimate)
    factor, last = task.slowed(best)
    move = Move(task.path, last.law)
    return OptimalMove(move, profile, task.dynamics, task.smoothing, len(trials), factor, last.excess)


def checked_together(
    planned: Sequence[OptimalMove], arm: ArmOnPath, assemble: Callable[[list[Move]], Sequence[Move]]
) -> list[Move]:
    """Slow all moves down until the limits hold for the motion as a whole, where one move shakes the arm for the next.

    Args:
        planned: The moves, each by itself within the limits.
        arm: The robot.
        assemble: Gives the whole motion, with rests and repetitions, for the moves.

    Returns:
        The moves.

    Raises:
        InputError: The limits do not hold even far slower.
    """
    upper, lower = planned[0].dynamics.upper[0], planned[0].dynamics.lower[0]

    def tried(factor: float) -> tuple[list[Move], float]:
        moves = [Move(each.move.path, slowed(each.move.law, factor)) for each in planned]
        demand = arm.demand(assemble(moves), None)
        used = np.maximum(demand.torque / upper, demand.torque / lower)
        return moves, float(np.max(np.maximum(used, np.abs(demand.speed) / planned[0].dynamics.speed_limit))) - 1.0

    moves, excess = tried(1.0)
    if excess <= 2.0 * TOLERANCE:
        return moves
    short, long, found = 1.0, 1.05, None
    while found is None or long / short > 1.01:
        factor = long if found is None else 0.5 * (short + long)
        moves, excess = tried(factor)
        if excess <= 2.0 * TOLERANCE:
            long, found = factor, moves
        elif found is None:
            short, long = factor, 1.15 * factor
        else:
            short = factor
        _refuse_slower(short, excess)
    return found


def _refuse_slower(factor: float, excess: float) -> None:
    if factor > SLOWEST:
        raise InputError(
            f"the torque of the feedforward exceeds its limits by {100 * excess:.3g} % even {factor:.3g} times slower "
            "than the fastest motion; raise the limits, lengthen smoothing, or lengthen dwell between the moves"
        )


@dataclass(frozen=True, eq=False)
class _Trial:
    """A smooth law with the excess of [torque above, torque below, speed] over its limit, shape (n, 3, M)."""

    law: TimeLaw
    time: FloatArray
    over: FloatArray
    factor: float

    @property
    def excess(self) -> float:
        """Largest excess, relative to the limit."""
        return float(np.max(self.over))

    @property
    def estimate(self) -> float:
        """Estimated duration after it was slowed down as far as the limits ask for [s]."""
        return self.law.duration * max(1.0, self.factor)


@dataclass(frozen=True, eq=False)
class _Task:
    """What stays the same while one move is planned."""

    path: AbstractPath
    arm: ArmOnPath
    near: FloatArray | None
    dynamics: PathDynamics
    smoothing: float
    backwards: bool

    def law(self, profile: FastestProfile) -> TimeLaw:
        """Return the smooth law of a profile, in the direction of travel."""
        law = smoothed_law(profile, self.smoothing, self.path.extent)
        return reversed_way(law) if self.backwards else law

    def tried(self, law: TimeLaw) -> _Trial:
        """Compare the torques of the feedforward and the speeds with the limits."""
        dynamics = self.dynamics
        demand = self.arm.demand([Move(self.path, law)], self.near)
        time, torque = demand.time, demand.torque
        share = law.evaluate(time, 0)[0] / self.path.extent
        share = 1.0 - share if self.backwards else share

        def at(values: FloatArray) -> FloatArray:
            return np.column_stack([np.interp(share, dynamics.grid, column) for column in values.T])

        upper, lower, static = at(dynamics.upper), at(dynamics.lower), at(dynamics.static)
        speed = np.abs(demand.speed) / dynamics.speed_limit
        with np.errstate(invalid="ignore"):
            over = np.stack((torque / upper - 1.0, torque / lower - 1.0, speed - 1.0), axis=1)
            used = np.maximum((torque - static) / (upper - static), (torque - static) / (lower - static))
        over = np.where(np.isfinite(over), over, -1.0)
        factor = max(float(np.sqrt(np.nanmax(np.maximum(used, 0.0)))), float(np.max(speed)))
        return _Trial(law, time, over, factor)

    def slowed(self, trial: _Trial) -> tuple[float, _Trial]:
        """Slow a law down until the limits hold; return the factor and the slower law.

        Raises:
            InputError: The limits do not hold even far slower.
        """
        if trial.excess <= TOLERANCE:
            return 1.0, trial
        short, long, found = 1.0, max(1.01, trial.factor), None
        while found is None or long / short > 1.0 + TOLERANCE:
            factor = long if found is None else 0.5 * (short + long)
            slower = self.tried(slowed(trial.law, factor))
            if slower.excess <= TOLERANCE:
                long, found = factor, slower
            elif found is None:
                short, long = factor, 1.1 * factor
            else:
                short = factor
            _refuse_slower(short, slower.excess)
        return long, found


def _tightened(
    tight: PathDynamics,
    dynamics: PathDynamics,
    profile: FastestProfile,
    trial: _Trial,
    smoothing: float,
) -> PathDynamics:
    """Lower the limits of the profile at the points whose motion, spread over the smoothing time, exceeds them."""
    time, over = trial.time, trial.over
    reduction = np.zeros((tight.grid.size, *over.shape[1:]))
    active = np.flatnonzero(np.max(over, axis=(1, 2)) > 0.2 * TOLERANCE)
    for i in active:
        distance = np.abs(profile.time - (time[i] - 0.5 * smoothing)) / (0.5 * smoothing)
        weight = np.maximum(1.0 - distance, 0.0)
        nearest = int(np.argmin(distance))
        weight[max(nearest - 1, 0) : nearest + 2] = np.maximum(weight[max(nearest - 1, 0) : nearest + 2], 0.5)
        reduction = np.maximum(reduction, weight[:, None, None] * np.maximum(over[i], 0.0))
    room = 0.05
    with np.errstate(invalid="ignore"):
        upper = tight.upper - np.where(reduction[:, 0] > 0.0, reduction[:, 0] * np.abs(dynamics.upper), 0.0)
        lower = tight.lower + np.where(reduction[:, 1] > 0.0, reduction[:, 1] * np.abs(dynamics.lower), 0.0)
        upper = np.maximum(upper, dynamics.static + room * (dynamics.upper - dynamics.static))
        lower = np.minimum(lower, dynamics.static - room * (dynamics.static - dynamics.lower))
    slope = tight.slope * (1.0 + reduction[:, 2])
    return replace(tight, upper=upper, lower=lower, slope=slope)
