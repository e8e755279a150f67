"""All fits of the study: the same starts for each of the six estimators."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.identify.graybox.covariance import parameter_covariance
from flexros.identify.graybox.fit import FitSettings, GrayBoxFit, fit
from flexros.identify.graybox.multistart import multistart, random_starts
from flexros.identify.graybox.problem import GrayBoxProblem, graybox_problem
from flexros.identify.graybox.refine import refine
from flexros.prediction.damped_least_squares import StopRule
from flexros.validation.campaigns.study.choices import REFERENCE, SIX
from flexros.validation.campaigns.study.quasi_newton import judged, quasi_newton
from flexros.validation.campaigns.study.spread import estimated_spread

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flexros.arrays import FloatArray
    from flexros.validation.campaigns.study.settings import StudySettings

GROUP = 10
"""Starts that are computed together."""


@dataclass(frozen=True, eq=False)
class EstimatorRun:
    """Fits of one estimator from S initial values.

    Attributes:
        values: Fitted values [SI], shape (S, P).
        iterations: Steps of each fit, shape (S,).
        user_cost: LLS cost of each model over all positions with user weights; infinite without a rest, shape (S,).
        optimal_cost: The same with optimal weights, shape (S,).
        peer_cost: LLS cost with user weights where a general-purpose search ended from the same starts; NaN for those
            from which it did not start, shape (S,).
    """

    values: FloatArray
    iterations: FloatArray
    user_cost: FloatArray
    optimal_cost: FloatArray
    peer_cost: FloatArray

    @classmethod
    def of_rows(cls, rows: Sequence[Mapping[str, Any]]) -> EstimatorRun:
        """Put together what `fitted_rows` gave for groups of starts."""
        fields = ("values", "iterations", "user_cost", "optimal_cost", "peer_cost")
        return cls(*(np.array([row[key] for row in rows], dtype=float) for key in fields))


@dataclass(frozen=True, eq=False)
class Study:
    """The study with everything its tables and pictures show.

    Attributes:
        problem: LLS with user weights over all positions, by whose cost all models are judged.
        runs: What each estimator found, by its name.
        best: Fit of lowest cost of the reference estimator.
        single: Number of the position that the estimator with one position took.
        refined: The reference estimator once more from `best`, with weights for whose mask the model's responses count
            instead of the measured ones: theory has no meaning for lines in a notch of the model. Theory and spread are
            those of this estimator.
        theory: Standard deviation of the logarithms at `refined` by (5) of the paper, shape (P,).
        corrected: The same with its correction, see `ParameterCovariance.factor`, shape (P,).
        spread: Standard deviation of the logarithms of fits to responses drawn anew, see `spread`, shape (P,).
        redrawn: Number of fits behind `spread`.
        explanation: What the covariance says of the model.
    """

    problem: GrayBoxProblem
    runs: dict[str, EstimatorRun]
    best: GrayBoxFit
    single: int
    refined: GrayBoxFit
    theory: FloatArray
    corrected: FloatArray
    spread: FloatArray
    redrawn: int
    explanation: str


def study_jobs(problem: GrayBoxProblem, settings: StudySettings) -> dict[str, tuple[str, int, list[list[float]], bool]]:
    """List the fits of the study in groups that can be computed anywhere.

    Args:
        problem: LLS with user weights over all positions.
        settings: Number and seed of the starts.

    Returns:
        Arguments of `fitted_rows` after the problem, by name of the group.
    """
    single = most_telling_position(problem)
    starts = random_starts(problem, settings.starts, settings.seed).tolist()
    return {
        f"{kind.name}_{first}_to_{first + len(starts[first : first + GROUP]) - 1}": (
            kind.name,
            single,
            starts[first : first + GROUP],
            first < settings.peers,
        )
        for kind in SIX
        for first in range(0, len(starts), GROUP)
    }


def fitted_rows(
    problem: GrayBoxProblem, kind: str, single: int, starts: list[list[float]], peer: bool
) -> dict[str, Any]:
    """Fit with one estimator from some starts, and judge the models by the same costs as all others.

    Args:
        problem: LLS with user weights over all positions.
        kind: Name of the estimator.
        single: Number of the position for the estimator that takes only one.
        starts: Starts [SI], shape (S, P).
        peer: Whether a general-purpose search starts there too.

    Returns:
        Under "rows" values, steps and costs of every fit, ready for JSON.
    """
    chosen = next(each for each in SIX if each.name == kind)
    frame = problem
    if not chosen.all_positions:
        frame = graybox_problem(problem.robot, [problem.responses[single]], problem.names)
    frame = frame.with_choice(chosen.estimator, chosen.weights)
    optimal = problem.with_choice("LLS", "optimal")
    rows = []
    for start, found in zip(starts, multistart(frame, np.array(starts), threads=1), strict=True):
        rows.append(
            {
                "values": found.values.tolist(),
                "iterations": found.iterations,
                "user_cost": judged(problem, found.values),
                "optimal_cost": judged(optimal, found.values),
                "peer_cost": judged(problem, quasi_newton(frame, np.array(start))) if peer else None,
            }
        )
    return {"rows": rows}


def study_of(problem: GrayBoxProblem, parts: Mapping[str, Mapping[str, Any]], settings: StudySettings) -> Study:
    """Put the study together.

    Args:
        problem: LLS with user weights over all positions.
        parts: What `fitted_rows` gave, by the names of `study_jobs`.
        settings: Settings of the study.

    Returns:
        The study, with the theory at the best model of the reference estimator.
    """
    runs = {
        kind.name: EstimatorRun.of_rows(
            [row for name, part in parts.items() if name.startswith(f"{kind.name}_") for row in part["rows"]]
        )
        for kind in SIX
    }
    reference = runs[REFERENCE]
    found = fit(problem, reference.values[int(np.argmin(reference.user_cost))])
    refined = refine(problem, found, estimator=problem.estimator.name, weights=problem.setting)
    theory, corrected = (parameter_covariance(refined.problem, refined.fit, correct) for correct in (False, True))
    return Study(
        problem=problem,
        runs=runs,
        best=found,
        single=most_telling_position(problem),
        refined=refined.fit,
        theory=theory.standard_deviation,
        corrected=corrected.standard_deviation,
        spread=estimated_spread(refined.problem, refined.fit, settings.redrawn, settings.seed),
        redrawn=settings.redrawn,
        explanation=corrected.explanation,
    )


def most_telling_position(problem: GrayBoxProblem) -> int:
    """Find the position whose responses alone give the smallest covariance of all parameters, as the paper does.

    Args:
        problem: The problem over all positions; theory and weights are those at the robot's own values.

    Returns:
        Number of the position of smallest determinant.
    """
    nominal = fit(problem, settings=FitSettings(StopRule(iterations=0, evaluations=0), relinearisations=0))
    weighed = problem.reweighted(problem.scale.nominal)
    sizes = []
    for place, response in enumerate(problem.responses):
        frame = graybox_problem(problem.robot, [response], problem.names, problem.estimator.name, problem.setting)
        matrix = parameter_covariance(replace(frame, weights=weighed.weights[place : place + 1]), nominal, False).matrix
        sizes.append(float(np.sum(np.log(np.maximum(np.linalg.eigvalsh(matrix), np.finfo(float).tiny)))))
    return int(np.argmin(sizes))
