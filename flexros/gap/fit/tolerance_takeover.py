"""Moves a parameter change from tolerated deviations, which have a prior penalty, to a candidate on that parameter."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects.kinds.model_change import AbstractChangedValues
from flexros.gap.candidates.candidate import OF_NUMBERS
from flexros.gap.fit.sum_of_squares import chi2_of

if TYPE_CHECKING:
    from collections.abc import Collection

    from flexros.arrays import BoolArray, FloatArray
    from flexros.gap.candidates.candidate import Candidate
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.residuals.fit_data import FitData


@dataclass(frozen=True, eq=False)
class Takeover:
    """A candidate in place of tolerated deviations.

    Attributes:
        gain: Prior penalty of the deviations that it takes over: the fall of their sum of squares [1].
        start: Parameters of the candidate with the same effect, in the units of the fit, shape (n_free,).
        replaced: Whether it takes over a tolerated parameter, shape (n_names,).
    """

    gain: float
    start: FloatArray
    replaced: BoolArray


def takeover(candidate: Candidate, fit: CandidateFit) -> Takeover | None:
    """Replace the tolerated deviations of the parameters that a candidate changes.

    The candidate and these deviations change the robot in the same way, so that the data cannot separate them: all that
    the candidate gains is the prior penalty of the deviations. Directions that were linearised elsewhere do not show
    it, as they are not equal enough.

    Args:
        candidate: The candidate.
        fit: A fit without it.

    Returns:
        The replacement; None where the candidate is no common factor on tolerated parameters.
    """
    predictor, tolerance = fit.predictor, fit.predictor.tolerance
    if not issubclass(candidate.effect, AbstractChangedValues) or len(candidate.free) != 1:
        return None
    effect = candidate.typical().effect
    assert isinstance(effect, AbstractChangedValues)
    replaced = _changed(effect.numbers(predictor.robot, candidate.location), fit)
    if not replaced.any():
        return None
    factor = float(np.exp(np.mean(tolerance.logarithms(fit.deviations)[replaced])))
    (free,) = candidate.free
    return Takeover(_freed(replaced, fit), np.array([free.encode(factor - 1)]), replaced)


def friction_takeover(candidate: Candidate, fit: CandidateFit) -> Takeover | None:
    """Replace the tolerated deviation of a nominal viscous friction by friction in addition to it.

    Args:
        candidate: Viscous friction.
        fit: A fit without it.

    Returns:
        The replacement; None where the nominal friction is not tolerated.
    """
    robot, tolerance = fit.predictor.robot, fit.predictor.tolerance
    (number,) = candidate.effect().numbers(robot, candidate.location)
    replaced = _changed((number,), fit)
    if not replaced.any():
        return None
    added = robot.parameters[number].value * float(np.expm1(tolerance.logarithms(fit.deviations)[replaced][0]))
    start = [one.encode(added) if one.name == "coefficient" else candidate.neutral(one) for one in candidate.free]
    return Takeover(_freed(replaced, fit), np.array(start), replaced)


def _changed(numbers: Collection[str], fit: CandidateFit) -> BoolArray:
    """Return whether a tolerated number of a fit is one of some, shape (n_names,)."""
    return np.array([name in numbers for name in fit.predictor.tolerance.names], dtype=bool)


def _freed(replaced: BoolArray, fit: CandidateFit) -> float:
    """Return the prior penalty of a fit that falls away with the deviations of some numbers [1]."""
    return fit.prior_penalty - float(np.sum(fit.predictor.tolerance.without(fit.deviations, replaced) ** 2))


def with_own_numbers(fit: CandidateFit, data: FitData, least: float) -> CandidateFit:
    """Return a fit whose effects have taken over the deviations of the numbers that they are errors of.

    A fit adds what an effect and a tolerated deviation change of a number, so the robot stays the same, and the prior
    penalty of the deviations falls away. Effects on several numbers, which deviate in different ways, take over none;
    beside fitted directions of many numbers there is nothing to take over, see `Predictor`.

    Args:
        fit: The fit.
        data: The fitted log.
        least: Deviation from which it is taken over [1].
    """
    predictor, tolerance = fit.predictor, fit.predictor.tolerance
    if tolerance.directions is not None:
        return fit
    changes = dict(zip(tolerance.names, np.expm1(tolerance.logarithms(fit.deviations)), strict=True))
    theta, robot = fit.theta.copy(), predictor.robot
    every = zip(fit.hypothesis, predictor.values(fit.theta), strict=True)
    sizes = [(candidate, free, values[free.name]) for candidate, values in every for free in candidate.free]
    for column, (candidate, free, value) in enumerate(sizes):
        own = candidate.effect().numbers(robot, candidate.location)
        if free.name not in OF_NUMBERS or len(own) != 1 or own[0] not in changes:
            continue
        place = predictor.n_effect + tolerance.names.index(own[0])
        if abs(fit.theta[place]) > least:
            nominal = 1.0 if free.name == "relative" else robot.parameters[own[0]].value
            theta[column], theta[place] = free.encode(value + changes[own[0]] * nominal), 0.0
    low, high = predictor.bounds
    if np.array_equal(theta, fit.theta) or not np.all((theta >= low) & (theta <= high)):
        return fit
    return replace(fit, theta=theta, chi2=float(chi2_of(predictor, data, theta[:, None])[0]))


def with_takeover(
    candidate: Candidate, fit: CandidateFit, gain: float, start: FloatArray, misfit: float = 1.0
) -> Takeover:
    """Choose how a candidate is added to a fit: in place of tolerated deviations where that gains more.

    Args:
        candidate: The candidate.
        fit: A fit without it.
        gain: Fall of the sum of squares that linear theory predicts [1].
        start: Initial value of the candidate that goes with it, in the units of the fit, shape (n_free,).
        misfit: Weight of the prior of tolerated deviations, see `FitData` [1].

    Returns:
        The gain [1], the initial value and what it takes over, which may be nothing.
    """
    replacement = takeover(candidate, fit)
    if replacement is not None and misfit * replacement.gain > gain:
        return replace(replacement, gain=misfit * replacement.gain)
    return Takeover(gain, start, np.zeros(len(fit.predictor.tolerance.names), dtype=bool))
