"""Numbers of an effect that the log does not show: they are left neutral."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects.kinds.law import AbstractLaw

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.gap.candidates.candidate import Candidate, Hypothesis
    from flexros.gap.fit.least_squares import CandidateFit


def without_least_number(one: CandidateFit) -> tuple[Hypothesis, FloatArray] | None:
    """Leave the number out that is least clearly other than neutral.

    Without a number x the sum of squares rises by about x^2 i(x) (Wald 1943), with the information i(x) that is left
    when all other numbers follow; it is zero where the log does not determine x. Only numbers of both signs are neutral
    at zero; phases are not, nor is the last number that an effect is there by.

    Args:
        one: The fit.

    Returns:
        The effects with one number less, and the others' numbers to start from, shape (n_fitted - 1,); None where
        every number is needed.
    """
    hypothesis, values = one.predictor.hypothesis, one.predictor.values(one.theta)
    columns = [(effect, number) for effect, candidate in enumerate(hypothesis) for number in range(len(candidate.free))]
    may_go = [_may_go(hypothesis[effect], number, values[effect]) for effect, number in columns]
    if not any(may_go):
        return None
    costs = [
        one.theta[column] ** 2 * _own_information(one.information, column) if may else np.inf
        for column, may in enumerate(may_go)
    ]
    column = int(np.argmin(costs))
    effect, number = columns[column]
    free = hypothesis[effect].free
    leaner = replace(hypothesis[effect], free=(*free[:number], *free[number + 1 :]))
    return (*hypothesis[:effect], leaner, *hypothesis[effect + 1 :]), np.delete(one.theta, column)


def _may_go(candidate: Candidate, number: int, values: dict[str, float]) -> bool:
    """Tell whether an effect is one without a number, which is zero then."""
    name = candidate.free[number].name
    if not candidate.free[number].signed or candidate.effect.ranges[name].scale == "phase":
        return False
    without = candidate.placed({**values, name: 0.0}).effect
    return isinstance(without, AbstractLaw) and not without.neutral


def _own_information(information: FloatArray, number: int) -> float:
    """Return the information on a number when all others are free: what Schur's complement leaves of it."""
    rest = np.delete(np.arange(len(information)), number)
    shared = information[rest, number]
    follow = np.linalg.lstsq(information[np.ix_(rest, rest)], shared, rcond=1e-12)[0]
    return max(float(information[number, number] - shared @ follow), 0.0)
