"""Fitting the numbers of a hypothesis to a log by its prediction errors."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.candidates.candidate import names_of
from flexros.gap.prediction.predictor import LANES

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from flexros.arrays import BoolArray, FloatArray
    from flexros.gap.prediction.predictor import Predictor
    from flexros.gap.residuals.fit_data import FitData

STEP = 1e-3
"""Step of the differences that make the derivatives, in the numbers that the fit moves [1] (chosen)."""
LONGEST = 1.5
"""Longest step of a number of an effect in one iteration: a factor of 4.5 where it is a logarithm [1] (chosen)."""
ENOUGH, EXACTLY = 0.1, 1e-3
"""The fit ends when the sum of squares falls by less than this [1]: the null needs it so fine, and the intervals of
slow effects, whose errors are smaller than white prediction errors tell, finer (chosen)."""
HOPE = 10.0
"""Times what linear theory promises that a fit may still gain [1] (chosen)."""
DAMPINGS = 10.0 ** np.arange(-8.0, 4.0, 1.5)
"""Dampings of a step that are tried side by side, over the information of each number [1] (chosen)."""
ALIKE = 1e-6
"""Largest information of a number to the unit of the dampings that are alike for all numbers [1] (chosen)."""
KEPT = 0.3
"""Share of the promised fall below which other steps are tried (chosen)."""
PLAIN = 4
"""Iterations before other steps are tried though some fall is left (chosen)."""
AHEAD = 0.1
"""Share of a step over which the second derivative is taken (Transtrum, Sethna 2012)."""
RUN_AWAY = 1e100
"""Derivatives of this size are of predictions that run away; their squares would leave the range of numbers."""
MOST_STARTS = 96
"""Largest number of starts of one hypothesis (chosen)."""


@dataclass(frozen=True, eq=False)
class CandidateFit:
    """A fitted hypothesis.

    Attributes:
        predictor: The hypothesis.
        theta: Numbers at the minimum, shape (n_fitted,).
        chi2: Sum of the squared weighted prediction errors and of the tolerated deviations in standard deviations.
        information: J'J + prior where it was linearised last, shape (n_fitted, n_fitted); empty where not computed.
        iterations: Iterations taken.
        converged: Whether the sum of squares fell no more.
    """

    predictor: Predictor
    theta: FloatArray
    chi2: float
    information: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))
    iterations: int = 0
    converged: bool = False

    @property
    def names(self) -> frozenset[str]:
        """Effects at places that it has."""
        return names_of(self.predictor.hypothesis)

    @property
    def price(self) -> float:
        """Sum of the squared tolerated deviations in standard deviations [1], a part of `chi2`."""
        return float(np.sum(self.theta[self.predictor.n_effect :] ** 2))


def chi2_of(predictor: Predictor, data: FitData, thetas: FloatArray) -> FloatArray:
    """Evaluate the sum of squares for many sets of numbers.

    Args:
        predictor: The hypothesis.
        data: Log and weights.
        thetas: Numbers, shape (n_fitted, sets).

    Returns:
        Sums of squares, infinite where the prediction diverges, shape (sets,).
    """
    sums = [
        _sums(predictor, data.residuals(predictor, thetas[:, first : first + LANES]), thetas[:, first : first + LANES])
        for first in range(0, thetas.shape[1], LANES)
    ]
    result: FloatArray = np.concatenate(sums)
    return result


def starts_of(predictor: Predictor) -> FloatArray:
    """List the starts of a hypothesis: all combinations of those of its numbers, or as many as allowed, evenly spread.

    Args:
        predictor: The hypothesis.

    Returns:
        Numbers, shape (n_fitted, starts); tolerated deviations are zero.
    """
    combinations = [sum(parts, ()) for parts in product(*(candidate.starts() for candidate in predictor.hypothesis))]
    grid = np.array(combinations, dtype=float).reshape(len(combinations), predictor.n_effect)
    kept = np.unique(np.linspace(0, len(grid) - 1, min(len(grid), MOST_STARTS)).round().astype(int))
    starts = grid[kept].T
    return np.vstack([starts, np.zeros((len(predictor.tolerance.names), starts.shape[1]))])


# Not `flexros.prediction.damped_least_squares`: that one solves from normal equations, one damping after another. Here
# a batch of dampings costs about as much as one, since the predictor has a lane for each; steps use the residuals
# themselves (curvature along the step), and parameters that the data cannot separate get a common damping scale.
def fit(
    predictor: Predictor,
    data: FitData,
    start: FloatArray,
    iterations: int = 12,
    tolerance_slopes: FloatArray | None = None,
    enough: float = ENOUGH,
    rival: float = np.inf,
) -> CandidateFit:
    """Find the numbers of least squares near a start (Levenberg 1944, Marquardt 1963).

    Derivatives are differences, side by side in the lanes of the predictor. Eight dampings are tried at once: each
    number damped by its own information (Marquardt). Where that gains far less than promised, the steps are bent along
    the curve of the prediction errors (Transtrum, Sethna 2012), and then all numbers are damped alike (Levenberg), so
    that of two numbers which the log cannot tell apart the one moves that it shows best.

    Args:
        predictor: The hypothesis.
        data: Log and weights.
        start: Numbers to start from, shape (n_fitted,).
        iterations: Most iterations.
        tolerance_slopes: Derivatives to the tolerated deviations that are held, which saves most of the work, shape
            (n_values, n_tolerated); None to compute them anew in each iteration.
        enough: The fit ends when the sum of squares falls by less than this [1].
        rival: Sum of squares of a better fit: this one ends where it has no hope to come near it.
    """
    theta = np.clip(np.array(start, dtype=float), *predictor.bounds)
    chi2, information, converged, done = np.inf, np.zeros((0, 0)), False, 0
    while done < iterations:
        done += 1
        line = linearise(predictor, data, theta, tolerance_slopes)
        chi2, information = line.chi2, line.information
        if not np.isfinite(chi2) or not len(theta):
            break
        promised = _promised(line, _free(predictor, theta, line))
        if promised < enough:
            converged = True
            break
        if chi2 - HOPE * promised > rival:
            break
        before, reached = chi2, theta
        for trials in _trials(predictor, data, theta, line):
            values = chi2_of(predictor, data, trials)
            best = int(np.argmin(values))
            if values[best] < chi2:
                reached, chi2 = trials[:, best], float(values[best])
            if before - chi2 > (KEPT * promised if done > PLAIN else enough):
                break
        del line, trials  # slopes are the largest arrays of a fit
        theta = reached
        if before - chi2 < enough:
            converged = True
            break
    return CandidateFit(predictor, theta, float(chi2), information, done, converged)


@dataclass(frozen=True, eq=False)
class Linearised:
    """A hypothesis near one set of numbers.

    Attributes:
        chi2: Sum of squares.
        residual: Weighted prediction errors r, shape (M n,).
        slopes: Their derivatives J, shape (M n, n_fitted).
        gradient: J'r and the prior's part, shape (n_fitted,).
        information: J'J and the prior's part, shape (n_fitted, n_fitted).
    """

    chi2: float
    residual: FloatArray
    slopes: FloatArray
    gradient: FloatArray
    information: FloatArray


def linearise(
    predictor: Predictor, data: FitData, theta: FloatArray, tolerance_slopes: FloatArray | None = None
) -> Linearised:
    """Linearise the prediction errors by differences.

    Args:
        predictor: The hypothesis.
        data: Log and weights.
        theta: Numbers, shape (n_fitted,).
        tolerance_slopes: As for `fit`.
    """
    P = len(theta) if tolerance_slopes is None else predictor.n_effect
    _, high = predictor.bounds
    signs = np.where(theta + STEP > high, -1.0, 1.0)
    base, J = np.zeros(0), np.zeros((0, 0))
    for first in range(0, max(P, 1), LANES - 1):
        group = range(first, min(first + LANES - 1, P))
        sets = np.repeat(theta[:, None], len(group) + 1, axis=1)
        for lane, number in enumerate(group):
            sets[number, lane + 1] += signs[number] * STEP
        residual = data.residuals(predictor, sets)
        if first == 0:
            base = residual[:, 0].copy()
            J = np.empty((len(base), len(theta)), order="F")
            if tolerance_slopes is not None:
                J[:, P:] = tolerance_slopes
        for lane, number in enumerate(group):
            slope = signs[number] / STEP * (residual[:, lane + 1] - base)
            J[:, number] = np.where(np.abs(slope) < RUN_AWAY, slope, 0.0)
    prior = np.zeros(len(theta))
    prior[predictor.n_effect :] = 1.0
    chi2 = float(_sums(predictor, base[:, None], theta[:, None])[0])
    gradient = J.T @ base if np.isfinite(chi2) else np.zeros(len(theta))
    return Linearised(chi2, base, J, gradient + prior * theta, J.T @ J + np.diag(prior))


def _free(predictor: Predictor, theta: FloatArray, line: Linearised) -> BoolArray:
    """Tell which numbers may move: all but those at a bound that would go beyond it."""
    low, high = predictor.bounds
    free: BoolArray = ~((theta <= low) & (line.gradient > 0) | (theta >= high) & (line.gradient < 0))
    return free


def _promised(line: Linearised, free: BoolArray) -> float:
    """Return by how much the sum of squares would fall with the best step of linear theory."""
    gradient, information = line.gradient[free], line.information[np.ix_(free, free)]
    return float(gradient @ np.linalg.lstsq(information, gradient, rcond=1e-12)[0])


def _trials(predictor: Predictor, data: FitData, theta: FloatArray, line: Linearised) -> Iterator[FloatArray]:
    """List damped steps, the more costly ones later, shape (n_fitted, dampings) each."""
    most = max(float(np.max(np.diag(line.information), initial=0.0)), 1e-300)
    own = [damping * (np.diag(line.information) + 1e-12 * most) for damping in DAMPINGS]
    alike = [np.full(len(theta), damping * ALIKE * most) for damping in DAMPINGS]
    straight = np.stack([_trial(predictor, theta, line, added) for added in own], axis=-1)
    yield straight
    yield _bent(predictor, data, theta, line, straight, own)
    yield np.stack([_trial(predictor, theta, line, added) for added in alike], axis=-1)


def _bent(
    predictor: Predictor,
    data: FitData,
    theta: FloatArray,
    line: Linearised,
    trials: FloatArray,
    added: Sequence[FloatArray],
) -> FloatArray:
    """Bend steps by half of what the second derivative of the errors along them asks for."""
    steps = trials - theta[:, None]
    ahead = data.residuals(predictor, theta[:, None] + AHEAD * steps) - line.residual[:, None]
    second = line.slopes.T @ (ahead / AHEAD - line.slopes @ steps) * (2 / AHEAD)
    second[~np.isfinite(second)] = 0.0
    free = _free(predictor, theta, line)
    for lane, more in enumerate(added):
        information = (line.information + np.diag(more))[np.ix_(free, free)]
        steps[free, lane] -= 0.5 * np.linalg.lstsq(information, second[free, lane], rcond=None)[0]
    low, high = predictor.bounds
    return np.clip(theta[:, None] + steps, low[:, None], high[:, None])


def _trial(predictor: Predictor, theta: FloatArray, line: Linearised, added: FloatArray) -> FloatArray:
    """Take one step with added information, shape (n_fitted,), no number of an effect farther than allowed."""
    free = _free(predictor, theta, line)
    information = line.information + np.diag(added)
    step = np.zeros(len(theta))
    step[free] = -np.linalg.lstsq(information[np.ix_(free, free)], line.gradient[free], rcond=None)[0]
    longest = float(np.max(np.abs(step[: predictor.n_effect]), initial=0.0))
    result: FloatArray = np.clip(theta + step * min(1.0, LONGEST / max(longest, 1e-300)), *predictor.bounds)
    return result


def _sums(predictor: Predictor, residuals: FloatArray, thetas: FloatArray) -> FloatArray:
    sums = np.einsum("ij,ij->j", residuals, residuals)[: thetas.shape[1]]
    sums = sums + np.sum(thetas[predictor.n_effect :] ** 2, axis=0)
    return np.where(np.isfinite(sums), sums, np.inf)


def best_of(fits: Sequence[CandidateFit]) -> CandidateFit:
    """Return the fit of the smallest sum of squares."""
    return min(fits, key=lambda one: one.chi2)
