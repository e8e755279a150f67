"""Linearisation of a hypothesis: derivatives of its weighted prediction errors to its parameters, by differences."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.fit.sum_of_squares import sums_of
from flexros.gap.prediction.compiled_plant import LANES

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.prediction.predictor import Predictor
    from flexros.gap.residuals.fit_data import FitData

STEP = 1e-3
"""Usual step of the differences that make the derivatives, in the units of the fit [1]."""
MULTIPLES = (1.0, -1.0, 3.0, -3.0, 9.0, -9.0, 0.3, -0.3)
"""Steps of differences over the usual one where predictions jump [1] (chosen)."""
FEW = 0.01
"""Share of the values that may jump [1] (chosen)."""
JUMP = 8.0
"""Derivative over the rms of the others of its parameter from which it is a jump [1] (chosen): without contacts most of
the largest ones of an elbow and a four-mass arm were 4 to 7 times as large, with jumps 50 to 430."""
DIVERGED = 1e100
"""Derivatives of this size are of diverging predictions; their squares would overflow."""


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

    def fall_by(self, step: FloatArray) -> float:
        """Return by how much the sum of squares falls with a step by linear theory.

        Args:
            step: Change of the parameters in the units of the fit, shape (n_fitted,).
        """
        return -float(2 * self.gradient @ step + step @ self.information @ step)


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
        return data.residuals(used, _sets(theta, group, steps))[:, : len(group)]

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
    chi2 = float(sums_of(predictor, data, base[:, None], theta[:, None])[0])
    gradient = J.T @ base if np.isfinite(chi2) else np.zeros(len(theta))
    return Linearised(chi2, base, J, gradient + prior * theta, J.T @ J + np.diag(prior))


def carried_on(
    line: Linearised, predictor: Predictor, data: FitData, theta: FloatArray, step: FloatArray, residual: FloatArray
) -> Linearised:
    """Linearise after a step by the derivatives before it, corrected by what it changed (Broyden 1965).

    J + (r - r_before - J h) h'D / h'D h for a step h, with the information of each parameter on the diagonal of D, so
    that the units of the parameters do not matter.

    Args:
        line: The hypothesis, linearised before the step; its slopes are overwritten, as they are large.
        predictor: Predictor of it.
        data: Log and weights.
        theta: Parameters after the step, in the units of the fit, shape (n_fitted,).
        step: The step, shape (n_fitted,).
        residual: Weighted prediction errors after it, shape (n_values,).
    """
    weights = np.diag(line.information) * step
    weights /= max(float(weights @ step), 1e-300)
    J, missed = line.slopes, residual - line.residual - line.slopes @ step
    if predictor.jumps:
        missed = without_jumps(missed[:, None])[:, 0]
    for column, weight in enumerate(weights):
        J[:, column] += weight * missed
    prior = np.zeros(len(theta))
    prior[predictor.n_effect :] = data.misfit
    chi2 = float(sums_of(predictor, data, residual[:, None], theta[:, None])[0])
    return Linearised(chi2, residual, J, J.T @ residual + prior * theta, J.T @ J + np.diag(prior))


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


def _sets(theta: FloatArray, numbers: Sequence[int], steps: FloatArray) -> FloatArray:
    """Return sets of parameters that differ by a step in one of them each; in none for -1."""
    sets = np.repeat(theta[:, None], len(numbers), axis=1)
    for lane, number in enumerate(numbers):
        if number >= 0:
            sets[number, lane] += steps[number]
    return sets


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
    forward = [multiple * usual for multiple in MULTIPLES]
    several = [np.where((theta + steps > high) | (theta + steps < low), -steps, steps) for steps in forward]
    for begin in range(0, len(theta), LANES):
        columns = list(range(begin, min(begin + LANES, len(theta))))
        differences = []
        for steps in several:
            residual = data.residuals(predictor, _sets(theta, columns, steps))[:, : len(columns)]
            differences.append((residual - line.residual[:, None]) / steps[columns])
        slopes = np.median(differences, axis=0)
        J[:, columns] = np.where(np.abs(slopes) < DIVERGED, slopes, 0.0)
    prior = line.information - line.slopes.T @ line.slopes
    gradient = J.T @ line.residual + np.diag(prior) * theta
    return Linearised(line.chi2, line.residual, J, gradient, J.T @ J + prior)
