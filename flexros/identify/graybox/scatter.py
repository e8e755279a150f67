"""Limits of residuals that chance explains: few blocks give variances that are themselves uncertain.

The squared residual of a line over a variance of nu complex degrees of freedom is F-distributed with 2 and 2 nu
degrees. Variances pooled over neighbouring lines are the same for all of them, so that a mean over lines scatters by
more than their number suggests. Where the weights of a fit are not optimal, the scatter of its parameters is added: it
moves lines of low weight by many of their standard deviations (derived).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.identify.frf.response_noise import response_noise
from flexros.identify.graybox.covariance import MISSES

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.identify.frf.response_noise import ResponseNoise
    from flexros.identify.graybox.covariance import ParameterCovariance
    from flexros.identify.graybox.fit import GrayBoxFit
    from flexros.identify.graybox.problem import GrayBoxProblem

UNEXPLAINED = 2.0
"""Mean squared residual over variance, all lines weighted equally, above which part is unexplained (chosen)."""

SURE = 0.999
"""Probability that chance stays below the limits (chosen)."""

_DRAWS, _MOST_RATIOS = 20_000, 50
"""Number of draws of means of ratios, and largest number of ratios in each (chosen)."""

_FEWEST = 3.0
"""Smallest assumed degrees of freedom: with two, the variance of an F-distribution is infinite."""


@dataclass(frozen=True)
class ScatterLimits:
    """Largest residuals that chance explains.

    Attributes:
        cost: Cost of the fit over its expected value.
        chi_square: Mean squared residual over variance, all lines weighted equally.
    """

    cost: float = MISSES
    chi_square: float = UNEXPLAINED


def scatter_limits(problem: GrayBoxProblem, fit: GrayBoxFit, covariance: ParameterCovariance) -> ScatterLimits:
    """Compute the limits of an identification.

    Args:
        problem: Measured responses, estimator and weights.
        fit: Result of the fit.
        covariance: Covariance of its parameters.

    Returns:
        The limits, at least `MISSES` and `UNEXPLAINED`; exactly these where the responses have no covariance.
    """
    noises = [noise for noise in map(response_noise, problem.responses) if noise is not None]
    if len(noises) < len(problem.responses):
        return ScatterLimits()
    response, slopes = problem.model_at(fit.values).response_and_jacobian(
        fit.values, problem.scale.per_value(fit.values)
    )
    variance = np.stack([noise.variance for noise in noises])
    used = problem.weights > 0
    degrees = max(min(noise.degrees_of_freedom for noise in noises), _FEWEST)
    width = max(1, round(degrees / max(1, _spare(noises[0]))))
    expected = np.where(used, problem.weights * problem.estimator.element_variance(variance, response), 0.0)
    weighted = _variance(expected / expected.sum(), degrees, width, 1.0 / problem.estimator.noise_share)
    lines = _variance(used / np.count_nonzero(used), degrees, width, 1.0)
    relative = np.where(used, 1.0 / np.sqrt(variance), 0.0)[..., None] * slopes
    information = np.real(np.tensordot(relative.conj(), relative, axes=([0, 1, 2, 3], [0, 1, 2, 3])))
    moved = information @ covariance.matrix / max(covariance.reduced_cost, 1.0) / np.count_nonzero(used)
    grown = degrees / (degrees - 1.0)
    mean = grown * (1.0 + float(np.trace(moved)))
    spread = grown**2 * (lines + 2.0 * float(np.trace(moved @ moved)))
    return ScatterLimits(max(MISSES, by_chance(1.0, weighted)), max(UNEXPLAINED, by_chance(mean, spread)))


def by_chance(mean: float, variance: float) -> float:
    """Return the bound of a mean of squares at probability `SURE`, for a scaled chi-square distribution.

    Args:
        mean: Its expected value.
        variance: Its variance.
    """
    from scipy.stats import chi2

    degrees = 2.0 * mean**2 / variance
    return mean / degrees * float(chi2.ppf(SURE, degrees))


def power_ratio(above: float, below: float, number: int) -> float:
    """Return the bound at probability `SURE` of a mean of ratios of two mean powers of equal expectation.

    Means of few ratios with few degrees of freedom have long tails, so they are drawn (seeded).

    Args:
        above: Complex degrees of freedom of the numerator.
        below: Those of the denominator.
        number: Number of independent ratios.
    """
    generator, shape = np.random.default_rng(0), (_DRAWS, min(max(number, 1), _MOST_RATIOS))
    top, bottom = (generator.gamma(degrees, 1.0 / degrees, shape) for degrees in (above, max(below, 1.0)))
    return float(np.quantile(np.mean(top / bottom, axis=1), SURE))


def _spare(noise: ResponseNoise) -> int:
    """Degrees of freedom of a single line, before pooling."""
    response = noise.response
    motors = len(response.input_names)
    if noise.kind == "total":
        return motors * (response.n_blocks - 1)
    return motors * response.n_blocks * (response.n_periods - 1)


def _variance(shares: FloatArray, degrees: float, width: int, single: float) -> float:
    """Relative variance of a weighted mean of squared errors over their variances.

    Args:
        shares: Shares of the elements, shape (Q, F, n_y, n_u), of sum 1.
        degrees: Degrees of freedom nu of each variance.
        width: Number of neighbouring lines with one common variance.
        single: Variance of one squared error over its variance: 1 if it is complex, 2 if real.
    """
    starts = np.arange(0, shares.shape[1], width)
    together = np.add.reduceat(shares.sum(axis=3), starts, axis=1)
    errors = single * (degrees - 1.0) / (degrees - 2.0) * float(np.sum(shares**2))
    return errors + float(np.sum(together**2)) / (degrees - 2.0)
