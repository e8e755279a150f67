"""Zero dynamics along a path: is the causal inverse bounded, and how long before the tool must the motors move?"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np

from flexros.errors import InputError
from flexros.robot.linear.zeros import zero_dynamics

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.feedforward.problem import FeedforwardProblem
    from flexros.robot.linear.zeros import ZeroDynamics

DECAY = 1e-6
"""Share of its largest value at which motion before that of the tool counts as rest [1] (chosen)."""

LONGEST = 60.0
"""Longest time for which the motors may move before the tool [s] (chosen)."""

ADVICE = "choose another output of the robot, another pose, or method flexible_joint or rigid"


@dataclass(frozen=True, eq=False)
class PoseVerdict:
    """Zero dynamics at a pose of a path.

    Attributes:
        zeros: The zero dynamics.
        pose: Arm coordinates [rad or m], shape (N,).
        time: Time on the trajectory [s].
    """

    zeros: ZeroDynamics
    pose: FloatArray
    time: float


_found: WeakKeyDictionary[FeedforwardProblem, tuple[PoseVerdict, ...]] = WeakKeyDictionary()
"""Verdicts by problem, which is not kept alive: its samples are as large as a log."""


def zero_dynamics_along(problem: FeedforwardProblem) -> tuple[PoseVerdict, ...]:
    """Compute the zero dynamics at poses spread over the path, including its start.

    The linearised model at rest in each pose is used, which is not sufficient for fast motion.

    Args:
        problem: Robot, trajectory and settings.

    Raises:
        InputError: The motors cannot set the output at one of the poses; the message names output and pose.
    """
    if problem not in _found:
        _found[problem] = _zero_dynamics_along(problem)
    return _found[problem]


def _zero_dynamics_along(problem: FeedforwardProblem) -> tuple[PoseVerdict, ...]:
    end = int(np.searchsorted(problem.time, problem.trajectory.duration))
    last = min(end, problem.n_samples - 1)
    samples = np.unique(np.linspace(0, last, problem.specification.zero_dynamics_poses).astype(int))
    times = problem.time[samples]
    found = []
    for pose, time in zip(problem.arm_position(problem.gear_motion(0, times)[0]), times, strict=True):
        verdict = PoseVerdict(zero_dynamics(problem.robot, pose, problem.output), pose, float(time))
        if not verdict.zeros.solvable:
            raise InputError(
                f"{_case(problem, verdict)} cannot be inverted: the motors do not move all components of the output "
                f"there; {ADVICE}"
            )
        found.append(verdict)
    return tuple(found)


def minimum_phase(problem: FeedforwardProblem) -> bool:
    """Return whether the zero dynamics are stable at all poses of the path, so that a causal inverse is bounded.

    Raises:
        InputError: See `zero_dynamics_along`.
    """
    return all(verdict.zeros.minimum_phase for verdict in zero_dynamics_along(problem))


def require_minimum_phase(problem: FeedforwardProblem) -> None:
    """Refuse a path with unstable zero dynamics at one of its poses.

    Time stepping computes the causal inverse, which grows without bound along an unstable zero (Moberg 2007, Paper B,
    section 3.2).

    Args:
        problem: Robot, trajectory and settings.

    Raises:
        InputError: Not minimum phase at one of the poses; the message names output, pose and zero.
    """
    for verdict in zero_dynamics_along(problem):
        if not verdict.zeros.minimum_phase:
            zero = verdict.zeros.unstable[np.argmax(verdict.zeros.unstable.real)]
            raise InputError(
                f"{_case(problem, verdict)} is non-minimum phase: its zero dynamics have the unstable zero "
                f"{_complex(zero)} 1/s, so the causal inverse that the dae method computes grows without bound; use "
                f"method stable_inversion, {ADVICE}"
            )


def actuation_time(problem: FeedforwardProblem) -> float:
    """Return the time for which the motors move before the tool in the bounded inverse, and at most so after it.

    The motion before grows as exp(p t) with the slowest unstable zero p; it is followed from `DECAY` of its final
    value on.

    Args:
        problem: Robot, trajectory and settings.

    Returns:
        Time [s]; 0 for a minimum-phase path.

    Raises:
        InputError: It would be longer than a minute; see also `zero_dynamics_along`.
    """
    slowest = [
        (float(verdict.zeros.unstable.real.min()), verdict)
        for verdict in zero_dynamics_along(problem)
        if verdict.zeros.unstable.size
    ]
    if not slowest:
        return 0.0
    speed, verdict = min(slowest, key=lambda pair: pair[0])
    time = -float(np.log(DECAY)) / speed
    if time > LONGEST:
        raise InputError(
            f"{_case(problem, verdict)} has an unstable zero of only {speed:.4g} 1/s, so the motors would move "
            f"{time:.4g} s before the tool, allowed are {LONGEST:g} s; {ADVICE}"
        )
    return time


def _case(problem: FeedforwardProblem, verdict: PoseVerdict) -> str:
    gears = np.round(verdict.pose[list(problem.robot.gear_rows)], 4).tolist()
    return (
        f"robot {problem.robot.name} with output '{verdict.zeros.output}' at t = {verdict.time:.4g} s, gears at {gears}"
    )


def _complex(number: complex) -> str:
    if abs(number.imag) < 1e-9 * abs(number):
        return f"{number.real:.4g}"
    return f"{number.real:.4g} +- {abs(number.imag):.4g}i"
