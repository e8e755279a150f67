"""Damped steps of a least-squares fit, straight and bent along the curvature of the prediction errors."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.fit.least_norm import least_norm
from flexros.gap.fit.sum_of_squares import sums_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from flexros.arrays import BoolArray, FloatArray
    from flexros.gap.fit.linearisation import Linearised
    from flexros.gap.prediction.predictor import Predictor
    from flexros.gap.residuals.fit_data import FitData

# Not `flexros.prediction.damped_least_squares`: that one solves from normal equations, one damping after another. Here
# a batch of dampings costs about as much as one, since the predictor has a lane for each; steps use the residuals
# themselves (curvature along the step), and parameters that the data cannot separate get a common damping scale.

DAMPINGS = 10.0 ** np.arange(-8.0, 4.0, 1.5)
"""Dampings of a step that are tried together, relative to the information of each parameter [1]."""
ALIKE = 1e-6
"""Unit of the dampings that are equal for all parameters, relative to the largest information [1]."""
AHEAD = 0.1
"""Share of a step over which the second derivative is taken (Transtrum, Sethna 2012) [1]."""


def may_move(predictor: Predictor, theta: FloatArray, line: Linearised) -> BoolArray:
    """Return which parameters may move: all but those at a bound that would leave it, shape (n_fitted,).

    Args:
        predictor: Predictor of the hypothesis.
        theta: Parameters in the units of the fit, shape (n_fitted,).
        line: The same, linearised.
    """
    low, high = predictor.bounds
    free: BoolArray = ~((theta <= low) & (line.gradient > 0) | (theta >= high) & (line.gradient < 0))
    return free


def predicted_fall(line: Linearised, free: BoolArray) -> float:
    """Return by how much the sum of squares would fall with the best step of linear theory.

    Args:
        line: The hypothesis, linearised.
        free: Which parameters may move, shape (n_fitted,).
    """
    gradient, information = line.gradient[free], line.information[np.ix_(free, free)]
    return float(gradient @ least_norm(information, gradient, 1e-12))


def best_step(
    predictor: Predictor, data: FitData, theta: FloatArray, line: Linearised, longest: float, well: float
) -> tuple[FloatArray, float, FloatArray]:
    """Take the damped step that lowers the sum of squares most.

    Args:
        predictor: Predictor of the hypothesis.
        data: Log and weights.
        theta: Parameters in the units of the fit, shape (n_fitted,).
        line: The same, linearised.
        longest: Longest step of the parameters of the effects [1].
        well: Fall of the sum of squares from which no more costly steps are tried [1].

    Returns:
        Where it leads, with the sum of squares and the weighted prediction errors there.
    """
    best, chi2, residual = theta, line.chi2, line.residual
    for trials in _trials(predictor, data, theta, line, longest):
        residuals = data.residuals(predictor, trials)
        sums = sums_of(predictor, data, residuals, trials)
        lowest = int(np.argmin(sums))
        if sums[lowest] < chi2:
            best, chi2, residual = trials[:, lowest], float(sums[lowest]), residuals[:, lowest].copy()
        if line.chi2 - chi2 > well:
            break
    return best, chi2, residual


def _trials(
    predictor: Predictor, data: FitData, theta: FloatArray, line: Linearised, longest: float
) -> Iterator[FloatArray]:
    """Generate damped steps, the more costly ones later, shape (n_fitted, n_dampings) each."""
    largest = max(float(np.max(np.diag(line.information), initial=0.0)), 1e-300)
    own = [damping * (np.diag(line.information) + 1e-12 * largest) for damping in DAMPINGS]
    alike = [np.full(len(theta), damping * ALIKE * largest) for damping in DAMPINGS]
    straight = np.stack([_trial(predictor, theta, line, added, longest) for added in own], axis=-1)
    yield straight
    yield _bent(predictor, data, theta, line, straight, own)
    yield np.stack([_trial(predictor, theta, line, added, longest) for added in alike], axis=-1)


def _bent(
    predictor: Predictor,
    data: FitData,
    theta: FloatArray,
    line: Linearised,
    trials: FloatArray,
    dampings: Sequence[FloatArray],
) -> FloatArray:
    """Bend steps by half of what the second derivative of the errors along them asks for."""
    steps = trials - theta[:, None]
    ahead = data.residuals(predictor, theta[:, None] + AHEAD * steps) - line.residual[:, None]
    second = line.slopes.T @ (ahead / AHEAD - line.slopes @ steps) * (2 / AHEAD)
    second[~np.isfinite(second)] = 0.0
    free = may_move(predictor, theta, line)
    for lane, damping in enumerate(dampings):
        information = (line.information + np.diag(damping))[np.ix_(free, free)]
        steps[free, lane] -= 0.5 * least_norm(information, second[free, lane])
    low, high = predictor.bounds
    return np.clip(theta[:, None] + steps, low[:, None], high[:, None])


def _trial(
    predictor: Predictor, theta: FloatArray, line: Linearised, damping: FloatArray, longest: float
) -> FloatArray:
    """Take one damped step, limited to the longest one of the effects' parameters, shape (n_fitted,)."""
    free = may_move(predictor, theta, line)
    information = line.information + np.diag(damping)
    step = np.zeros(len(theta))
    step[free] = -least_norm(information[np.ix_(free, free)], line.gradient[free])
    length = float(np.max(np.abs(step[: predictor.n_effect]), initial=0.0))
    result: FloatArray = np.clip(theta + step * min(1.0, longest / max(length, 1e-300)), *predictor.bounds)
    return result
