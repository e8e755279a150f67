"""Pruning: parameters of an effect that the log does not show are left neutral."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects.kinds.curve import AbstractCurve
from flexros.effects.kinds.law import AbstractLaw
from flexros.gap.fit.least_norm import least_norm

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.gap.candidates.candidate import Candidate, Hypothesis
    from flexros.gap.fit.candidate_fit import CandidateFit


def without_least_parameter(fit: CandidateFit) -> tuple[Hypothesis, FloatArray] | None:
    """Leave out the parameter whose difference from neutral is the least significant.

    Without a parameter x the sum of squares rises by about x^2 i(x) (Wald 1943), where i(x) is the information that is
    left when all other parameters are free; it is zero where the log does not determine x. Only parameters of both
    signs are neutral at zero. Phases are not, nor is the parameter without which the effect vanishes.

    Args:
        fit: The fit.

    Returns:
        The candidates with one parameter less, and an initial value of the others, shape (n_fitted - 1,); None where
        every parameter is needed.
    """
    hypothesis, values = fit.hypothesis, fit.predictor.values(fit.theta)
    columns = [(effect, index) for effect, candidate in enumerate(hypothesis) for index in range(len(candidate.free))]
    may_go = [_may_go(hypothesis[effect], index, values[effect]) for effect, index in columns]
    if not any(may_go):
        return None
    rises = [
        fit.theta[column] ** 2 * own_information(fit.information, column) if may else np.inf
        for column, may in enumerate(may_go)
    ]
    column = int(np.argmin(rises))
    effect, index = columns[column]
    free = hypothesis[effect].free
    pruned = replace(hypothesis[effect], free=(*free[:index], *free[index + 1 :]))
    return (*hypothesis[:effect], pruned, *hypothesis[effect + 1 :]), np.delete(fit.theta, column)


def _may_go(candidate: Candidate, index: int, values: dict[str, float]) -> bool:
    """Return whether an effect remains one with a parameter at zero."""
    name = candidate.free[index].name
    if issubclass(candidate.effect, AbstractCurve):
        return False  # between its knots it has no other form
    if not candidate.free[index].signed or candidate.effect.ranges[name].scale == "phase":
        return False
    without = candidate.placed({**values, name: 0.0}).effect
    return isinstance(without, AbstractLaw) and not without.neutral


def own_information(information: FloatArray, index: int) -> float:
    """Return the information on a parameter when all others are free (Schur complement)."""
    rest = np.delete(np.arange(len(information)), index)
    shared = information[rest, index]
    follow = least_norm(information[np.ix_(rest, rest)], shared, 1e-12)
    return max(float(information[index, index] - shared @ follow), 0.0)
