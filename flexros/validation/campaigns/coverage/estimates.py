"""Estimates of one repetition by every estimator: values, deviations, verdicts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.identify.graybox.covariance import parameter_covariance
from flexros.identify.graybox.fit import GrayBoxFit, fit
from flexros.identify.graybox.identifiability import identifiability
from flexros.identify.graybox.multistart import best
from flexros.identify.graybox.problem import GrayBoxProblem, graybox_problem
from flexros.identify.graybox.refine import refine
from flexros.robot.robot import load_robot
from flexros.validation.campaigns.coverage.experiment import group_responses

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.identify.frf.frequency_response import FrequencyResponse
    from flexros.robot.robot import Robot
    from flexros.scenario.scenario import Scenario
    from flexros.validation.campaigns.coverage.settings import CoverageSettings, RepetitionGroup


@dataclass(frozen=True)
class Way:
    """One way to estimate.

    Attributes:
        name: Name in tables.
        estimator: "LLS", "LLSM" or "NLS".
        weights: "user", "optimal" or "combined".
        first: Estimator of the fit from the random starts, which has user weights; the fit with the weights of this way
            goes on from there, as `flexros identify` does.
    """

    name: str
    estimator: str
    weights: str
    first: str


DEFAULT = "LLS combined"
"""The default of `flexros identify`."""

WAYS = (
    Way(DEFAULT, "LLS", "combined", "LLS"),
    Way("LLS user", "LLS", "user", "LLS"),
    Way("LLS optimal", "LLS", "optimal", "LLS"),
    Way("LLSM user", "LLSM", "user", "LLSM"),
    Way("NLS optimal", "NLS", "optimal", "LLS"),
)
"""The ways that are compared; NLS continues from LLS, because it seldom converges from far away."""


def group_estimates(
    scenario: Scenario, names: tuple[str, ...], settings: CoverageSettings, group: RepetitionGroup
) -> dict[str, Any]:
    """Simulate a group of repetitions and estimate in every way.

    Args:
        scenario: The experiment.
        names: Unknown parameters, length P.
        settings: Starts of the fits.
        group: Phases and noise.

    Returns:
        For JSON: by way, lists with one entry per repetition; see `repetition_estimates`.
    """
    robot = load_robot(scenario.robot)
    rows = [
        repetition_estimates(robot, names, responses, settings, seed)
        for responses, seed in zip(group_responses(scenario, group), group.noise_seeds, strict=True)
    ]
    return {way.name: [row[way.name] for row in rows] for way in WAYS}


def repetition_estimates(
    robot: Robot,
    names: tuple[str, ...],
    responses: Sequence[FrequencyResponse],
    settings: CoverageSettings,
    seed: int,
) -> dict[str, dict[str, Any]]:
    """Estimate in every way from the responses of one repetition.

    Args:
        robot: Model and truth.
        names: Unknown parameters, length P.
        responses: One per position.
        settings: Starts of the fits.
        seed: Seed of the starts.

    Returns:
        For JSON: by way the fitted values [SI] and their deviations (of logarithms), each of length P, the verdicts,
        cost over what noise explains, the factor on the covariance, and whether the fit converged.
    """
    problem = graybox_problem(robot, responses, names)
    factors = settings.start_factor ** np.random.default_rng(seed).uniform(-1.0, 1.0, (settings.starts, len(names)))
    starts = problem.scale.nominal * factors
    firsts = {
        estimator: best([fit(problem.with_choice(estimator, "user"), start) for start in starts])
        for estimator in dict.fromkeys(way.first for way in WAYS)
    }
    rows = {}
    for way in WAYS:
        ended = refine(problem, firsts[way.first], estimator=way.estimator, weights=way.weights)
        rows[way.name] = _row(ended.problem, ended.fit)
    return rows


def _row(problem: GrayBoxProblem, found: GrayBoxFit) -> dict[str, Any]:
    covariance = parameter_covariance(problem, found)
    judged = identifiability(problem, found, covariance)
    return {
        "values": found.values.tolist(),
        "deviations": covariance.standard_deviation.tolist(),
        "verdicts": [each.verdict for each in judged.parameters],
        "reduced_cost": covariance.reduced_cost,
        "factor": covariance.factor,
        "converged": found.converged,
    }
