"""Limits by chance: distributions of mean squared misfits and of ratios of powers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from flexros.identify.graybox.covariance import MISSES
from flexros.identify.graybox.scatter import UNEXPLAINED, ScatterLimits, by_chance, power_ratio, scatter_limits
from flexros.identify.result import IdentificationResult


def with_degrees(result: IdentificationResult, degrees: float) -> ScatterLimits:
    """Compute the limits for another number of degrees of freedom behind the variances."""
    responses = tuple(replace(response, degrees_of_freedom=degrees) for response in result.problem.responses)
    return scatter_limits(replace(result.problem, responses=responses), result.fit, result.covariance)


def test_mean_of_squares_stays_below_the_limit_nearly_always() -> None:
    generator = np.random.default_rng(1)
    means = generator.chisquare(12, 100_000) / 12
    assert np.mean(means > by_chance(1.0, 2 / 12)) == pytest.approx(1e-3, rel=0.4)


def test_ratios_of_few_degrees_reach_far() -> None:
    generator = np.random.default_rng(1)
    ratios = generator.f(8, 8, (50_000, 14)).mean(axis=1)
    assert np.mean(ratios > power_ratio(4, 4, 14)) == pytest.approx(1e-3, rel=0.6)
    assert power_ratio(4, 4, 14) > power_ratio(12, 12, 14) > 1.0


def test_few_degrees_of_freedom_widen_the_limits(clear: IdentificationResult) -> None:
    few, many = with_degrees(clear, 4.0), with_degrees(clear, 1000.0)
    assert few.cost > many.cost >= MISSES
    assert few.chi_square > many.chi_square >= UNEXPLAINED


def test_scatter_of_parameters_widens_the_limit_of_lines_only(clear: IdentificationResult) -> None:
    covariance = replace(clear.covariance, matrix=100 * clear.covariance.matrix)
    wide = scatter_limits(clear.problem, clear.fit, covariance)
    assert wide.chi_square > 2 * clear.limits.chi_square
    assert wide.cost == clear.limits.cost


def test_limits_without_covariance_of_responses(make: Callable[..., IdentificationResult]) -> None:
    assert make(10.0, known=False).limits == ScatterLimits(MISSES, UNEXPLAINED)
