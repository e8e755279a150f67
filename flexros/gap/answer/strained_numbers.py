"""Numbers of the model that an answer moves far out of their tolerance: they are part of what repairs it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from pydantic import ValidationError

from flexros.effects import place_effects
from flexros.effects.friction.viscous_friction import ViscousFriction
from flexros.effects.kinds.base import PlacedEffect, effects
from flexros.effects.kinds.relative_error import AbstractRelativeError
from flexros.errors import InputError
from flexros.gap.fit.torques.rough_bodies import fitted_bodies
from flexros.robot.parameters import DAMPER

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flexros.gap.answer.decision import Findings
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.robot import Robot

STRAINED, STRAINED_ALONE = 4.0, 8.0
"""Deviation from which a number is far out of its tolerance, over this [1] (chosen): of some forty numbers of an arm of
six axes one is beyond three now and then; without any effect, errors of torques within their tolerance moved one of an
exact model by 4.6."""
SHOWN = 3
"""Numbers of the model beyond their tolerance that are stated one by one [1] (chosen)."""
LARGE, SEVERAL = 0.5, 2.0
"""Logarithm of a factor, and deviation over the tolerance, from which both together are far out as well [1] (chosen): a
guessed inertia, tolerated by 30 %, was 0.42 times its value, which no torques within their tolerance make of one."""


def strained_numbers(findings: Findings) -> dict[str, float]:
    """Return the factors of the numbers that the chosen explanation moves far out of their tolerance, by name [1].

    Where the prior of tolerances counts little beside many samples, numbers that are tolerated take up what an effect
    like a payload would, and sizes of effects are those beside them. What the robot file lacks is not among them.

    Args:
        findings: The fits of the log.

    Returns:
        Factors, that of the number farthest out of its tolerance first.
    """
    chosen = findings.explanations.chosen
    lacked = findings.unknown.names(findings.model.robot)  # the patch states these
    found = far_out(chosen, STRAINED if findings.explanations.detected else STRAINED_ALONE)
    return {name: factor for name, factor in found.items() if name not in lacked}


def far_out(fit: CandidateFit, least: float, *, large: bool = True) -> dict[str, float]:
    """Return the factors of the numbers that a fit moves far out of their tolerance, by name [1].

    Args:
        fit: The fit.
        least: Deviation from which it is far, however small the tolerance [1].
        large: Whether a large factor is far out from a smaller deviation on, but for the damping of a spring: it takes
            up what torques are off by.

    Returns:
        Factors, that of the number farthest out of its tolerance first.
    """
    tolerance = fit.predictor.tolerance
    sizes = np.abs(tolerance.by_name(fit.deviations))
    logarithms = np.asarray(tolerance.logarithms(fit.deviations))
    of_spring = np.array([name.endswith(DAMPER) for name in tolerance.names], dtype=bool)
    far = (sizes > least) | (large & ~of_spring & (sizes > SEVERAL) & (np.abs(logarithms) > LARGE))
    far &= np.array(tolerance.deviations) > 0  # all others are those of an effect, or exact
    return {tolerance.names[k]: float(np.exp(logarithms[k])) for k in np.argsort(-sizes) if far[k]}


def moved_words(fit: CandidateFit, factors: Mapping[str, float]) -> str:
    """Write by how much a fit moves numbers, e.g. "motor_1.inertia by +28.6 %, 5.7 times its tolerance of 5 %".

    Figures are those of the change itself, so that they agree; how far a number is out counts on logarithms.

    Args:
        fit: The fit.
        factors: Their factors by name [1].
    """
    tolerance = fit.predictor.tolerance
    stated = dict(zip(tolerance.names, tolerance.deviations, strict=True))
    named = [
        f"{name} {_changed(factor)} {abs(factor - 1) / stated[name]:.2g} times its tolerance of "
        f"{100 * stated[name]:.3g} %"
        for name, factor in list(factors.items())[:SHOWN]
    ]
    return "; ".join(named) + (f" and {len(factors) - SHOWN} more" if len(factors) > SHOWN else "")


def _changed(factor: float) -> str:
    """Say by how much a number changes that is this many times its value, or to how many times it."""
    return f"by {100 * (factor - 1):+.1f} %," if 0.5 < factor < 2.0 else f"to {factor:.3g} times, by"


def as_effects(robot: Robot, placed: Sequence[PlacedEffect], factors: Mapping[str, float]) -> tuple[PlacedEffect, ...]:
    """Return numbers of a robot with effects, scaled by factors, as further effects.

    A fit adds what factors and effects change of a number, while effects of a patch act one after the other.

    Args:
        robot: The nominal robot.
        placed: Effects that come before.
        factors: Factors by name of the parameter [1].

    Returns:
        The effects; numbers that no effect changes, such as lengths, are left out. Empty where the robot would not be
        physical, or an effect would be beyond what it may be.
    """
    try:
        now = place_effects(robot, placed).robot
        found = [*fitted_bodies(robot, factors)]
        for name, factor in factors.items():
            location, added = name.rpartition(".")[0], (factor - 1.0) * robot.parameters[name].value
            if name == f"{location}.viscous_friction":
                found.append(PlacedEffect(ViscousFriction(coefficient=added), location))
            for kind in _errors_of(now, name, location):
                found.append(PlacedEffect(kind(relative=added / now.parameters[name].value), location))
        place_effects(robot, (*placed, *found))
    except (InputError, ValidationError):
        return ()
    return tuple(found)


def _errors_of(robot: Robot, name: str, location: str) -> list[type[AbstractRelativeError]]:
    """Return the relative error of one number alone; none where there is no such effect."""
    return [
        kind
        for kind in effects().values()
        if issubclass(kind, AbstractRelativeError)
        and location in kind().locations(robot)
        and kind().numbers(robot, location) == (name,)
    ][:1]
