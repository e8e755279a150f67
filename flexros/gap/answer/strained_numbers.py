"""Numbers of the model that an answer moves far out of their tolerance: they are part of what repairs it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.effects import place_effects
from flexros.effects.friction.viscous_friction import ViscousFriction
from flexros.effects.kinds.base import PlacedEffect, effects
from flexros.effects.kinds.relative_error import AbstractRelativeError
from flexros.errors import InputError
from flexros.gap.fit.torques.rough_bodies import fitted_bodies

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flexros.gap.answer.decision import Findings
    from flexros.robot import Robot

STRAINED, STRAINED_ALONE = 4.0, 8.0
"""Deviation from which a number is far out of its tolerance, over this [1] (chosen): of some forty numbers of an arm of
six axes one is beyond three now and then; without any effect, errors of torques within their tolerance moved one of an
exact model by 4.6."""


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
    tolerance = chosen.predictor.tolerance
    sizes = np.asarray(tolerance.by_name(chosen.deviations))
    factors = np.exp(np.asarray(tolerance.logarithms(chosen.deviations)))
    lacked = findings.unknown.names(findings.model.robot)  # the patch states these
    least = STRAINED if findings.explanations.detected else STRAINED_ALONE
    far = [k for k in np.argsort(-np.abs(sizes)) if abs(sizes[k]) > least and tolerance.names[k] not in lacked]
    return {tolerance.names[k]: float(factors[k]) for k in far}


def as_effects(robot: Robot, placed: Sequence[PlacedEffect], factors: Mapping[str, float]) -> tuple[PlacedEffect, ...]:
    """Return numbers of a robot with effects, scaled by factors, as further effects.

    A fit adds what factors and effects change of a number, while effects of a patch act one after the other.

    Args:
        robot: The nominal robot.
        placed: Effects that come before.
        factors: Factors by name of the parameter [1].

    Returns:
        The effects; numbers that no effect changes, such as lengths, are left out. Empty where the robot would not be
        physical.
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
    except InputError:
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
