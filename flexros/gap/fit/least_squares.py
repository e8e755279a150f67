"""Least-squares fit of the parameters of a hypothesis to a log, through its prediction errors."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import lru_cache
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.fit.candidate_fit import CandidateFit
from flexros.gap.fit.least_norm import least_norm
from flexros.gap.prediction.compiled_plant import LANES
from flexros.gap.settings import FitSettings

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from flexros.arrays import BoolArray, FloatArray
    from flexros.gap.candidates.candidate import Hypothesis
    from flexros.gap.prediction.predictor import Predictor
    from flexros.gap.residuals.fit_data import FitData

# Not `flexros.prediction.damped_least_squares`: that one solves from normal equations, one damping after another. Here
# a batch of dampings costs about as much as one, since the predictor has a lane for each; steps use the residuals
# themselves (curvature along the step), and parameters that the data cannot separate get a common damping scale.

FIT = FitSettings()
"""Settings of a fit unless others are given."""
STEP = 1e-3
"""Usual step of the differences that make the derivatives, in the units of the fit [1]."""
DAMPINGS = 10.0 ** np.arange(-8.0, 4.0, 1.5)
"""Dampings of a step that are tried together, relative to the information of each parameter [1]."""
ALIKE = 1e-6
"""Unit of the dampings that are equal for all parameters, relative to the largest information [1]."""
KEPT = 0.3
"""Share of the predicted fall below which further steps are tried [1]."""
LASTING = 0.7
"""Share of the predicted fall from which the slopes of the last step serve for the next one [1] (chosen)."""
STRAIGHT = 4
"""Iterations in which straight steps suffice where they lower the sum of squares at all."""
AHEAD = 0.1
"""Share of a step over which the second derivative is taken (Transtrum, Sethna 2012) [1]."""
MULTIPLES = (1.0, -1.0, 3.0, -3.0, 9.0, -9.0, 0.3, -0.3)
"""Steps of differences over the usual one where predictions jump [1] (chosen)."""
FEW = 0.01
"""Share of the values that may jump [1] (chosen)."""
JUMP = 8.0
"""Derivative over the rms of the others of its parameter from which it is a jump [1] (chosen): without contacts most of
the largest ones of an elbow and a four-mass arm were 4 to 7 times as large, with jumps 50 to 430."""
DIVERGED = 1e100
"""Derivatives of this size are of diverging predictions; their squares would overflow."""


def chi2_of(predictor: Predictor, data: FitData, thetas: FloatArray) -> FloatArray:
    """Evaluate the sum of squares for many sets of parameters.

    Args:
        predictor: Predictor of the hypothesis.
        data: Log and weights.
        thetas: Parameters in the units of the fit, shape (n_fitted, sets).

    Returns:
        Sums of squares, infinite where the prediction diverges, shape (sets,).
    """
    groups = [thetas[:, begin : begin + LANES] for begin in range(0, thetas.shape[1], LANES)]
    sums: FloatArray = np.concatenate(
        [_sums(predictor, data, data.residuals(predictor, group), group) for group in groups]
    )
    return sums


def initial_values(predictor: Predictor) -> FloatArray:
    """List initial values of a hypothesis.

    Args:
        predictor: Predictor of the hypothesis.

    Returns:
        Parameters in the units of the fit, tolerated deviations zero, shape (n_fitted, n_combinations).
    """
    values = starts_of(predictor.hypothesis)
    return np.vstack([values, np.zeros((predictor.tolerance.n_free, values.shape[1]))])


def starts_of(hypothesis: Hypothesis, most: int = FIT.most_starts, *, of_one_size: bool = False) -> FloatArray:
    """List all combinations of the initial values of some candidates, or `most` of them, evenly spread.

    Args:
        hypothesis: The candidates.
        most: Largest number of combinations.
        of_one_size: As for `Candidate.starts`.

    Returns:
        Their parameters in the units of the fit, shape (n_effect, n_combinations).
    """
    combinations = [sum(parts, ()) for parts in product(*(one.starts(of_one_size=of_one_size) for one in hypothesis))]
    n_effect = sum(len(candidate.free) for candidate in hypothesis)
    grid = np.array(combinations, dtype=float).reshape(len(combinations), n_effect)
    kept = np.unique(np.linspace(0, len(grid) - 1, min(len(grid), most)).round().astype(int))
    starts: FloatArray = grid[kept].T
    return starts


def fit(
    predictor: Predictor,
    data: FitData,
    start: FloatArray,
    iterations: int = 12,
    *,
    tolerance_slopes: FloatArray | None = None,
    first_slopes: FloatArray | None = None,
    enough: float | None = None,
    rival: float = np.inf,
    share: float = 0.0,
    settings: FitSettings = FIT,
    stop: Callable[[], bool] | None = None,
) -> CandidateFit:
    """Minimise the sum of squares from an initial value (Levenberg 1944, Marquardt 1963).

    Derivatives are differences, computed together in the lanes of the predictor. Eight dampings are tried at once, each
    parameter damped by its own information (Marquardt). Where that gains far less than predicted, the steps are bent
    along the curvature of the prediction errors (Transtrum, Sethna 2012), and then all parameters are damped equally
    (Levenberg), so that of two parameters that the log cannot separate the better determined one moves.

    Args:
        predictor: Predictor of the hypothesis.
        data: Log and weights.
        start: Initial value in the units of the fit, shape (n_fitted,).
        iterations: Most iterations.
        tolerance_slopes: Derivatives of the weighted prediction errors to the tolerated deviations, held fixed, which
            saves most of the work, shape (n_values, n_tolerated); None to compute them anew in each iteration.
        first_slopes: The same for the first iteration alone: further ones use them while sums fall as predicted.
        enough: Fall of the sum of squares below which the fit ends [1]; default: that of the settings.
        rival: Sum of squares of a better fit: this one ends where it has no hope to come near it.
        share: Fall below which the fit ends as well, over what is left above the floor [1]: where the hypothesis lacks
            much, steps shorten by a constant factor, and a fall of less than one would take dozens of them.
        settings: Limits of steps and of the end.
        stop: Asked after each iteration; True ends the fit where it is.
    """
    least = settings.enough if enough is None else enough
    theta = np.clip(np.array(start, dtype=float), *predictor.bounds)
    chi2, information, converged, done = np.inf, np.zeros((0, 0)), False, 0
    slopes = first_slopes if tolerance_slopes is None else tolerance_slopes
    many = predictor.tolerance.n_free >= LANES
    known: FloatArray | None = None
    while done < iterations:
        done += 1
        line = linearise(predictor, data, theta, slopes, residual=known)
        exact = slopes is tolerance_slopes
        chi2, information = line.chi2, line.information
        limit = max(least, share * (chi2 - data.n_values)) if share else least
        if not np.isfinite(chi2) or not len(theta):
            break
        predicted = _predicted_fall(line, may_move(predictor, theta, line))
        if predicted < limit and not exact:
            slopes, known = None, line.residual
            continue
        if predicted < limit:
            converged = True
            break
        if chi2 - settings.hope * predicted > rival:
            break
        well = KEPT * predicted if done > STRAIGHT else limit
        theta, chi2, known = _best_step(predictor, data, theta, line, settings.longest_step, well)
        fall = line.chi2 - chi2
        if tolerance_slopes is None:
            # of many tolerated deviations the slopes change little: those of the last step serve while they do
            lasting = many and fall > max(LASTING * predicted, limit)
            slopes = line.slopes[:, predictor.n_effect :] if lasting else None
        del line  # slopes are the largest arrays of a fit
        if fall < limit and exact:
            converged = True
            break
        if done < iterations and stop is not None and stop():
            break
    return CandidateFit(predictor, theta, float(chi2), information, done, converged)


@dataclass(frozen=True, eq=False)
class Linearised:
    """A hypothesis, linearised.

    Attributes:
        chi2: Sum of squares [1].
        residual: Weighted prediction errors r, shape (n_values,).
        slopes: Their derivatives J to the parameters, shape (n_values, n_fitted).
        gradient: J'r and the part of the prior, shape (n_fitted,).
        information: J'J and the part of the prior, shape (n_fitted, n_fitted).
    """

    chi2: float
    residual: FloatArray
    slopes: FloatArray
    gradient: FloatArray
    information: FloatArray


def linearise(
    predictor: Predictor,
    data: FitData,
    theta: FloatArray,
    tolerance_slopes: FloatArray | None = None,
    *,
    residual: FloatArray | None = None,
) -> Linearised:
    """Linearise the weighted prediction errors by differences.

    Args:
        predictor: Predictor of the hypothesis.
        data: Log and weights.
        theta: Parameters in the units of the fit, shape (n_fitted,).
        tolerance_slopes: As for `fit`.
        residual: Weighted prediction errors, where they are known, shape (n_values,).
    """
    own, every = predictor.n_effect, len(theta)
    moved = every if tolerance_slopes is None else own
    coarse = predictor.coarse if moved - own >= LANES else None
    exactly = moved if coarse is None else own
    _, high = predictor.bounds
    steps = STEP * predictor.fineness
    steps = np.where(theta + steps > high, -steps, steps)
    # the first lane of the first pass has the parameters themselves, all others a step: lanes yield the same bits
    passes = [(predictor, group) for group in _groups(0, exactly, known=residual is not None)]
    if coarse is not None:  # they change a prediction a little and smoothly
        passes += [(coarse, group) for group in _groups(exactly, moved)]

    def stepped(one: tuple[Predictor, list[int]]) -> FloatArray:
        used, group = one
        sets = np.repeat(theta[:, None], len(group), axis=1)
        for lane, index in enumerate(group):
            if index >= 0:
                sets[index, lane] += steps[index]
        return data.residuals(used, sets)[:, : len(group)]

    base, around, J = residual, residual, np.empty((0 if residual is None else len(residual), every), order="F")
    with ThreadPoolExecutor(data.settings.cores if len(passes) > 1 else 1) as pool:
        for (_, group), found in zip(passes, pool.map(stepped, passes), strict=True):
            if group[0] < 0:
                around = found[:, 0].copy()
                group, found = group[1:], found[:, 1:]
            assert around is not None
            base = around if base is None else base
            J = J if len(J) else np.empty((len(around), every), order="F")
            slopes = (found - around[:, None]) / steps[group]
            slopes = np.where(np.abs(slopes) < DIVERGED, slopes, 0.0)
            J[:, group] = without_jumps(slopes) if predictor.jumps else slopes
    assert base is not None
    if tolerance_slopes is not None:
        J[:, own:] = tolerance_slopes
    prior = np.zeros(len(theta))
    prior[predictor.n_effect :] = data.misfit
    chi2 = float(_sums(predictor, data, base[:, None], theta[:, None])[0])
    gradient = J.T @ base if np.isfinite(chi2) else np.zeros(len(theta))
    return Linearised(chi2, base, J, gradient + prior * theta, J.T @ J + np.diag(prior))


@lru_cache(maxsize=1)
def linearised(fit: CandidateFit, data: FitData) -> Linearised:
    """Linearise a fit; the last one is kept, as what is left out and how well sizes are known ask for the same.

    Args:
        fit: The fit.
        data: Log and weights.
    """
    return linearise(fit.predictor, data, fit.theta)


def _groups(begin: int, end: int, *, known: bool = False) -> list[list[int]]:
    """Divide the numbers of parameters into passes; -1, for no step, is the first of all unless that is known."""
    numbers = [*([] if known else [-1]), *range(begin, end)]
    return [numbers[first : first + LANES] for first in range(0, len(numbers), LANES)]


def without_jumps(slopes: FloatArray) -> FloatArray:
    """Leave out the derivatives of the few values that jump between two sets of parameters.

    Where a contact begins a step earlier, the difference of two predictions over a small change of a parameter is no
    derivative. A dozen of such values made tolerated numbers seem known far better than they were.

    Args:
        slopes: Derivatives, shape (n_values, n_parameters).

    Returns:
        The same, zero where they are more than `JUMP` times the rms of those of their parameter without the largest
        few.
    """
    few = max(1, round(FEW * len(slopes)))
    size = np.abs(slopes)
    usual = np.partition(size, len(size) - few, axis=0)[: len(size) - few]
    smooth: FloatArray = np.where(size <= JUMP * np.sqrt(np.mean(usual**2, axis=0)), slopes, 0.0)
    return smooth


def with_smooth_slopes(line: Linearised, predictor: Predictor, data: FitData, theta: FloatArray) -> Linearised:
    """Return a linearisation whose derivatives are medians of differences over several steps.

    Of a few values a contact begins earlier or later with one of the steps; with most it does not.

    Args:
        line: The hypothesis, linearised.
        predictor: Predictor of it.
        data: Log and weights.
        theta: Parameters in the units of the fit, shape (n_fitted,).
    """
    low, high = predictor.bounds
    usual, J = STEP * predictor.fineness, np.empty_like(line.slopes)
    for begin in range(0, len(theta), LANES):
        columns = np.arange(begin, min(begin + LANES, len(theta)))
        differences = []
        for multiple in MULTIPLES:
            steps = multiple * usual[columns]
            beyond = (theta[columns] + steps > high[columns]) | (theta[columns] + steps < low[columns])
            steps = np.where(beyond, -steps, steps)
            sets = np.repeat(theta[:, None], len(columns), axis=1)
            sets[columns, np.arange(len(columns))] += steps
            residual = data.residuals(predictor, sets)[:, : len(columns)]
            differences.append((residual - line.residual[:, None]) / steps)
        slopes = np.median(differences, axis=0)
        J[:, columns] = np.where(np.abs(slopes) < DIVERGED, slopes, 0.0)
    prior = line.information - line.slopes.T @ line.slopes
    gradient = J.T @ line.residual + np.diag(prior) * theta
    return Linearised(line.chi2, line.residual, J, gradient, J.T @ J + prior)


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


def _predicted_fall(line: Linearised, free: BoolArray) -> float:
    """Return by how much the sum of squares would fall with the best step of linear theory."""
    gradient, information = line.gradient[free], line.information[np.ix_(free, free)]
    return float(gradient @ least_norm(information, gradient, 1e-12))


def _best_step(
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
        sums = _sums(predictor, data, residuals, trials)
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


def _sums(predictor: Predictor, data: FitData, residuals: FloatArray, thetas: FloatArray) -> FloatArray:
    sums = np.einsum("ij,ij->j", residuals, residuals)[: thetas.shape[1]]
    sums = sums + data.misfit * np.sum(thetas[predictor.n_effect :] ** 2, axis=0)
    return np.where(np.isfinite(sums), sums, np.inf)
