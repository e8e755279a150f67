"""The numbers of a fit in the units of its effects, with their covariance."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.fit.parameter_covariance import parameter_covariance
from flexros.gap.fit.units import unit_of_parameter
from flexros.gap.schema import CauseParameter

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.effects import PlacedEffect
    from flexros.gap.fit.least_squares import CandidateFit
    from flexros.gap.residuals.fit_data import FitData


def placed(one: CandidateFit) -> tuple[PlacedEffect, ...]:
    """Return the effects of a fit with their numbers."""
    values = one.predictor.values(one.theta)
    return tuple(candidate.placed(numbers) for candidate, numbers in zip(one.predictor.hypothesis, values))


def covariance_of(one: CandidateFit, data: FitData | None = None) -> tuple[tuple[str, ...], FloatArray]:
    """Compute the covariance of the fitted numbers of the effects, in their units.

    Args:
        one: The fit.
        data: The log that it was fitted to; without it errors that are not white do not count, which is quick.

    Returns:
        Names, e.g. "coulomb_friction@motor_1.level", and covariance, shape (p, p).
    """
    number = one.predictor.n_effect
    whole = np.linalg.pinv(one.information) if data is None else parameter_covariance(one, data)
    covariance = whole[:number, :number]
    slopes = one.predictor.slopes(one.theta)
    names = tuple(f"{candidate.name}.{free.name}" for candidate in one.predictor.hypothesis for free in candidate.free)
    return names, covariance * np.outer(slopes, slopes)


def parameters_of(one: CandidateFit, data: FitData | None = None) -> list[dict[str, CauseParameter]]:
    """Return the numbers of every effect of a fit with their standard deviations."""
    _, covariance = covariance_of(one, data)
    spread = iter(np.sqrt(np.maximum(np.diag(covariance), 0.0)))
    values = one.predictor.values(one.theta)
    return [
        {
            name: CauseParameter(
                value=value, std=float(next(spread)), unit=unit_of_parameter(candidate, name, one.predictor.robot)
            )
            for name, value in numbers.items()
        }
        for candidate, numbers in zip(one.predictor.hypothesis, values)
    ]
