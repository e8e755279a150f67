"""Integration step of predictors: as long as the fastest motion of the robot allows."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from flexros.robot.linear.linearise import linear_model

if TYPE_CHECKING:
    from flexros.robot import Robot
    from flexros.robot.linear.linearise import LinearModel

SHORTEST, LONGEST, LONGEST_BENT = 5e-4, 1.25e-2, 2.5e-3
"""Bounds of the step [s] (chosen): effects with fast states need the first. Torques of a log are held from sample to
sample, and jumps of dry friction are placed within a step; but friction that depends on the speed is the same in all of
a step, and servos follow jumps of their commands, so that these take steps of at most the third."""
FAST = 5
"""Most steps per sample for states that may be faster than the robot; what is much faster than a sample does not show
(chosen)."""
STABLE = 2.5
"""Largest step times the largest eigenvalue [1]: Runge-Kutta steps of order four grow from 2.78 on."""
LONGEST_IMPLICIT = 1e-3
"""Longest implicit step of servos [s] (chosen): a tenth of the time in which a stiff one brings a joint to its
command."""
HELD, ROUGH = 3, 2
"""Implicit steps per sample under torques that are held, and where only the change of a prediction counts (chosen)."""
MOST = 64
"""Most steps per sample (chosen), for joints with much damping and little inertia."""
TURN, TURN_OF_MANY = 0.2, 0.4
"""Largest step times the largest eigenvalue [rad], and where a sample has `FAST` steps or more: the error of a step is
its fifth power over 120 (chosen). A motion as fast as that shows little in the samples."""
DECAY = 1.0
"""The same for motions that die out without swinging (chosen): they soon forget the error of a step."""
ROUGH_TURN = 1.0
"""The same where only the change of a prediction counts, and an error of a percent of it is none (chosen)."""


def substeps(
    robot: Robot,
    sample_time: float,
    friction: tuple[float, ...] = (),
    *,
    fast: bool = False,
    curved: bool = False,
    rough: bool = False,
) -> int:
    """Return the Runge-Kutta steps per sample.

    Args:
        robot: The robot.
        sample_time: Time between two samples [s].
        friction: Viscous friction of all motors beside that of the robot [Nm s/rad or N s/m]; empty for none.
        fast: Whether effects have states that may be faster than the robot.
        curved: Whether effects are dry friction that depends on the speed.
        rough: Whether the difference of two predictions with these steps is all that counts.
    """
    rates = _eigenvalues(robot, friction)
    fastest = max(max(map(abs, rates)), 1e-9)
    turn = max(TURN, min(TURN_OF_MANY, fastest * sample_time / FAST))
    exact = 1 / max(max(abs(one) / (DECAY if _dies_out(one) else turn) for one in rates), 1e-9)
    longest = LONGEST_BENT if curved or robot.commands == "position" else LONGEST
    exact, longest = (ROUGH_TURN / fastest, max(longest, sample_time)) if rough else (exact, longest)
    step = max(SHORTEST, sample_time / FAST) if fast else min(max(exact, SHORTEST), longest)
    step = min(step, max(STABLE / fastest, sample_time / MOST))
    return max(1, int(np.ceil(sample_time / step - 1e-9)))


@dataclass(frozen=True)
class IntegrationSteps:
    """Integration steps of a predictor.

    Attributes:
        number: Steps per sample.
        implicit: Whether they are implicit in the stiffness and the damping of the motors, see
            `flexros.simulate.implicit_step`; else they are Runge-Kutta steps.
    """

    number: int
    implicit: bool


def is_finer(steps: IntegrationSteps, others: IntegrationSteps) -> bool:
    """Return whether steps of the same kind are more than others."""
    return steps.implicit == others.implicit and steps.number > others.number


def integration_steps(
    robot: Robot,
    sample_time: float,
    friction: tuple[float, ...] = (),
    *,
    may_be_implicit: bool,
    fast: bool = False,
    curved: bool = False,
    rough: bool = False,
) -> IntegrationSteps:
    """Return the steps for a robot: implicit ones where motions die out within a sample.

    Servos and friction stop light joints much faster than anything else moves, and Runge-Kutta steps would follow that.
    Fast motions that oscillate need them.

    Args:
        robot: The robot.
        sample_time: Time between two samples [s].
        friction: Viscous friction of all motors beside that of the robot [Nm s/rad or N s/m]; empty for none.
        may_be_implicit: Whether implicit steps exist for the plant.
        fast: Whether effects have states that may be faster than the robot.
        curved: Whether effects are dry friction that depends on the speed.
        rough: Whether the difference of two predictions with these steps is all that counts.
    """
    if may_be_implicit and _is_stiff(robot, sample_time, friction):
        return IntegrationSteps(_implicit_substeps(robot, sample_time, fast=fast, rough=rough), implicit=True)
    return IntegrationSteps(
        substeps(robot, sample_time, friction, fast=fast, curved=curved, rough=rough), implicit=False
    )


def _is_stiff(robot: Robot, sample_time: float, friction: tuple[float, ...]) -> bool:
    """Return whether implicit steps are fewer, and all motions that are too fast for them die out without swinging."""
    number = _implicit_substeps(robot, sample_time)
    if substeps(robot, sample_time, friction) <= number:
        return False
    quick = [one for one in _eigenvalues(robot, friction) if abs(one) * sample_time > TURN_OF_MANY * number]
    return all(map(_dies_out, quick))


def _dies_out(rate: complex) -> bool:
    """Return whether the motion of an eigenvalue dies out without swinging."""
    return abs(rate.imag) < -rate.real


def _implicit_substeps(robot: Robot, sample_time: float, *, fast: bool = False, rough: bool = False) -> int:
    """Return the implicit steps per sample; servos follow jumps of their commands, torques of a log are held."""
    if robot.commands == "position":
        step = min(sample_time / FAST, LONGEST_IMPLICIT)
    else:
        step = min(sample_time / (FAST if fast else HELD), LONGEST)
    step = max(SHORTEST, sample_time / ROUGH if rough else step)
    return max(1, int(np.ceil(sample_time / step - 1e-9)))


@lru_cache(maxsize=256)
def _eigenvalues(robot: Robot, friction: tuple[float, ...]) -> tuple[complex, ...]:
    """Return the eigenvalues of a robot at home with more viscous friction [rad/s]."""
    model = _at_home(robot)
    if any(friction):
        model = replace(model, damping=model.damping + model.input @ np.diag(friction) @ model.encoder)
    return tuple(map(complex, np.linalg.eigvals(model.matrices()[0])))


@lru_cache(maxsize=32)
def _at_home(robot: Robot) -> LinearModel:
    return linear_model(robot)
