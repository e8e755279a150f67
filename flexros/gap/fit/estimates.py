"""Estimates of a fit: the parameters of its effects in their units, with their standard deviations."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects.kinds.curve import AbstractCurve
from flexros.gap.candidates.candidate import simpler
from flexros.gap.fit.uncertainty.between_logs import with_variation_between_logs
from flexros.gap.fit.uncertainty.covariance import fit_covariance, inverse_of
from flexros.gap.schema import CauseParameter

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from flexros.arrays import FloatArray
    from flexros.effects import PlacedEffect
    from flexros.gap.candidates.candidate import Candidate, FreeParameter
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.residuals.fit_data import FitData
    from flexros.gap.settings import RankingSettings
    from flexros.robot import Robot

ROUNDING = 1e-9
"""Standard deviation over its value below which a fit is no minimum but one that has diverged [1]: no sensor is that
exact, and no derivative by differences."""
_UNIT = re.compile(r"\[([^\]]+)\]")


def placed_effects(fit: CandidateFit) -> tuple[PlacedEffect, ...]:
    """Return the effects of a fit with their fitted parameters."""
    values = fit.predictor.values(fit.theta)
    return tuple(candidate.placed(parameters) for candidate, parameters in zip(fit.hypothesis, values))


def parameters_of(
    fit: CandidateFit, data: FitData | None = None, form: RankingSettings | None = None, held: FitData | None = None
) -> list[dict[str, CauseParameter]]:
    """Return the parameters of every effect of a fit with their standard deviations; arguments as `covariance_of`."""
    _, covariance = covariance_of(fit, data, form, held)
    deviations = iter(np.sqrt(np.maximum(np.diag(covariance), 0.0)))
    values = fit.predictor.values(fit.theta)
    return [
        {
            free.name: _parameter(candidate, free, parameters, float(next(deviations)), fit.predictor.robot)
            for free in candidate.free
        }
        for candidate, parameters in zip(fit.hypothesis, values)
    ]


def _parameter(
    candidate: Candidate, free: FreeParameter, values: Mapping[str, float], std: float, robot: Robot
) -> CauseParameter:
    value = values[free.name]
    angle = free.signed and candidate.neutral(free) is None  # a phase is known as well at zero
    turned = free.name in candidate.effect.ranges and candidate.effect.ranges[free.name].scale == "phase"
    return CauseParameter(
        value=float(np.remainder(value + np.pi, 2 * np.pi) - np.pi) if turned else value,
        std=std,
        unit=unit_of_parameter(candidate, free.name, robot),
        at_limit=free.name in candidate.at_limit(values),
        determined=std > ROUNDING * abs(value) and (angle or std <= abs(value)),
    )


def determined(candidate: Candidate, parameters: Mapping[str, CauseParameter]) -> bool:
    """Return whether a log determines any of the sizes of an effect: its deviation is not above it.

    Args:
        candidate: The effect.
        parameters: Its fitted parameters by name.
    """
    return any(parameters[free.name].determined for free in sizes_of(candidate))


def clearness(sizes: Iterable[CauseParameter]) -> float:
    """Return the largest determined size of an effect over its standard deviation [1]; 0 without one.

    Args:
        sizes: Its sizes.
    """
    return max((abs(size.value) / max(size.std, 1e-300) for size in sizes if size.determined), default=0.0)


def sizes_of(candidate: Candidate) -> tuple[FreeParameter, ...]:
    """Return the free parameters that make up the size of an effect, or all where none does."""
    return tuple(free for free in candidate.free if candidate.neutral(free) is not None) or candidate.free


def beyond_search(fit: CandidateFit) -> frozenset[str]:
    """Return the effects of a fit, effect@location, of which a size ended at the limit of its search: no findings.

    A law that a curve extends is one value of it, here and there: what all values are together counts. Without
    Coulomb friction the patch of a leg had negative friction, by a curve over position that began from there.
    """
    curves = [one for one in fit.hypothesis if issubclass(one.effect, AbstractCurve)]
    within = frozenset[str]().union(*(simpler(one) for one in curves))
    return frozenset(
        candidate.name
        for candidate, values in zip(fit.hypothesis, fit.predictor.values(fit.theta), strict=True)
        if candidate.name not in within and candidate.at_limit(values) & {free.name for free in sizes_of(candidate)}
    )


def covariance_of(
    fit: CandidateFit, data: FitData | None = None, form: RankingSettings | None = None, held: FitData | None = None
) -> tuple[tuple[str, ...], FloatArray]:
    """Compute the covariance of the parameters of the effects, in their units.

    Args:
        fit: The fit.
        data: The log that it was fitted to; None for the quick covariance, which holds for white residuals.
        form: Settings with the model-form errors of effects; None for what the residuals show alone.
        held: A log that was not fitted, whose sizes may differ; None for none.

    Returns:
        Names, e.g. "coulomb_friction@motor_1.level", and covariance, shape (p, p).
    """
    n_effect = fit.predictor.n_effect
    whole = inverse_of(fit.information) if data is None else fit_covariance(fit, data, form)
    whole = whole if held is None else with_variation_between_logs(whole, fit, held, form)
    slopes = fit.predictor.slopes(fit.theta)
    names = tuple(f"{candidate.name}.{free.name}" for candidate in fit.hypothesis for free in candidate.free)
    return names, whole[:n_effect, :n_effect] * np.outer(slopes, slopes)


def unit_of_parameter(candidate: Candidate, name: str, robot: Robot) -> str:
    """Return the SI unit of a parameter of a candidate.

    The descriptions of parameters state it in brackets, for rotary and linear motion as in "[rad or m]".

    Args:
        candidate: The candidate, whose location is rotary or linear.
        name: Name of the parameter.
        robot: The robot.
    """
    text = candidate.effect.model_fields[name].description or ""
    found = _UNIT.search(text)
    units = (found.group(1) if found else "1").split(" or ")
    return units[-1] if len(units) > 1 and not _rotary(candidate.location, robot) else units[0]


def _rotary(location: str, robot: Robot) -> bool:
    rotary = {motor.name: motor.rotary for motor in robot.motors} | {joint.name: joint.rotary for joint in robot.joints}
    return rotary.get(location, True)
