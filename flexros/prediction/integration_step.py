"""Integration step of predictors: as long as the fastest motion of the robot allows."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from flexros.robot.linear.linearise import linear_model

if TYPE_CHECKING:
    from flexros.robot import Robot

SHORTEST, LONGEST = 5e-4, 2.5e-3
"""Bounds of the step [s] (chosen): effects with fast states need the first; with the second, the reversals of dry
friction are still placed well within a sample of the lowest rates."""
FAST = 5
"""Most steps per sample for states that may be faster than the robot; what is much faster than a sample does not show
(chosen)."""
STABLE = 2.5
"""Largest step times the largest eigenvalue [1]: Runge-Kutta steps of order four grow from 2.78 on."""
MOST = 64
"""Most steps per sample (chosen), for joints with much damping and little inertia."""
TURN, TURN_OF_MANY = 0.2, 0.4
"""Largest step times the largest eigenvalue [rad], and where a sample has `FAST` steps or more: the error of a step is
its fifth power over 120 (chosen). A motion as fast as that shows little in the samples."""
ROUGH_TURN = 1.0
"""The same where only the change of a prediction counts, and an error of a percent of it is none (chosen)."""


def substeps(robot: Robot, sample_time: float, *, fast: bool = False, rough: bool = False) -> int:
    """Return the Runge-Kutta steps per sample.

    Args:
        robot: The robot.
        sample_time: Time between two samples [s].
        fast: Whether effects have states that may be faster than the robot.
        rough: Whether the difference of two predictions with these steps is all that counts.
    """
    fastest = _fastest(robot)
    exact = max(TURN, min(TURN_OF_MANY, fastest * sample_time / FAST)) / fastest
    exact, longest = (ROUGH_TURN / fastest, max(LONGEST, sample_time)) if rough else (exact, LONGEST)
    step = max(SHORTEST, sample_time / FAST) if fast else min(max(exact, SHORTEST), longest)
    step = min(step, max(STABLE / fastest, sample_time / MOST))
    return max(1, int(np.ceil(sample_time / step - 1e-9)))


def stops_too_fast(robot: Robot, sample_time: float, steps: int) -> bool:
    """Return whether a robot has motions that die out too fast for some steps per sample.

    Args:
        robot: The robot.
        sample_time: Time between two samples [s].
        steps: Steps per sample.
    """
    return _fastest(robot) * sample_time > STABLE * steps


def least_inertia(friction: float, sample_time: float, steps: int) -> float:
    """Return the inertia with which friction lets a motor die out slowly enough: friction T / (STABLE steps).

    Args:
        friction: Viscous friction of the motor [Nm s/rad or N s/m].
        sample_time: Time T between two samples [s].
        steps: Steps per sample.

    Returns:
        The inertia [kg m2 or kg].
    """
    return friction * sample_time / (STABLE * steps)


@lru_cache(maxsize=32)
def _fastest(robot: Robot) -> float:
    """Return the largest eigenvalue of a robot at home [rad/s]."""
    A = linear_model(robot).matrices()[0]
    return max(float(np.abs(np.linalg.eigvals(A)).max()), 1e-9)
