"""Check that the causal inverse of the robot is bounded, before the DAE is solved."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.robot.linear.zeros import zero_dynamics

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.feedforward.problem import FeedforwardProblem
    from flexros.robot.linear.zeros import ZeroDynamics


def require_minimum_phase(problem: FeedforwardProblem) -> None:
    """Check the zero dynamics at poses spread over the path, including its start.

    Time stepping computes the causal inverse, which grows without bound along an unstable zero (Moberg 2007, Paper B,
    section 3.2). The check uses the linearised model at rest in each pose; it is not sufficient for fast motion.

    Args:
        problem: Robot, trajectory and settings.

    Raises:
        InputError: Not minimum phase at one of the poses; the message names output, pose and zero.
    """
    end = int(np.searchsorted(problem.time, problem.trajectory.duration))
    last = min(end, problem.n_samples - 1)
    samples = np.unique(np.linspace(0, last, problem.specification.zero_dynamics_poses).astype(int))
    times = problem.time[samples]
    for pose, time in zip(problem.arm_position(problem.gear_motion(0, times)[0]), times, strict=True):
        verdict = zero_dynamics(problem.robot, pose, problem.output)
        if not verdict.minimum_phase:
            raise InputError(_message(problem, verdict, pose, float(time)))


def _message(problem: FeedforwardProblem, verdict: ZeroDynamics, pose: FloatArray, time: float) -> str:
    gears = np.round(pose[list(problem.robot.gear_rows)], 4).tolist()
    case = f"robot {problem.robot.name} with output '{verdict.output}' at t = {time:.4g} s, gears at {gears}"
    advice = "choose another output of the robot, another pose, or method flexible_joint or rigid"
    if not verdict.solvable:
        return f"{case} cannot be inverted: the motors do not move all components of the output there; {advice}"
    zero = verdict.unstable[np.argmax(verdict.unstable.real)]
    return (
        f"{case} is non-minimum phase: its zero dynamics have the unstable zero {_complex(zero)} 1/s, so the causal "
        f"inverse that the dae method computes grows without bound; {advice}"
    )


def _complex(number: complex) -> str:
    if abs(number.imag) < 1e-9 * abs(number):
        return f"{number.real:.4g}"
    return f"{number.real:.4g} +- {abs(number.imag):.4g}i"
