"""Figures of the study: reasonable models, springs within a factor of 2, Table 1, theory against spread."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.validation.campaigns.study.choices import BEST, REASONABLE, REFERENCE, SIX, StudyEstimator

if TYPE_CHECKING:
    from flexros.arrays import BoolArray, FloatArray, IntArray
    from flexros.validation.campaigns.study.jobs import Study


@dataclass(frozen=True)
class EstimatorShare:
    """Number of good models of one estimator.

    Attributes:
        kind: The estimator and what was published of it.
        reasonable: Share of models with a normalised LLS cost with user weights of at most 1.5.
        peer: The same for a general-purpose quasi-Newton search from the same starts.
        springs: Share of models with all springs but one within a factor of 2 of the best model's.
        all_springs: The same with all springs.
        iterations: Mean number of steps of a fit.
    """

    kind: StudyEstimator
    reasonable: float
    peer: float
    springs: float
    all_springs: float
    iterations: float


@dataclass(frozen=True)
class Statistics:
    """One row of Table 1: a parameter over that of the best model, among the best models.

    Attributes:
        name: Name of the parameter.
        least: Smallest.
        median: Median.
        largest: Largest.
        mean: Mean.
        deviation: Standard deviation over the models from different starts.
        spread: Standard deviation over responses drawn anew.
        theory: Standard deviation by (5).
        corrected: The same with its correction.
    """

    name: str
    least: float
    median: float
    largest: float
    mean: float
    deviation: float
    spread: float
    theory: float
    corrected: float


def normalised_costs(study: Study, name: str, weights: str = "user") -> FloatArray:
    """Return the LLS costs of an estimator's models over the lowest of all models (figures 3 and 4).

    Args:
        study: The study.
        name: Name of the estimator.
        weights: "user" or "optimal".

    Returns:
        Costs, lowest first, shape (S,).
    """
    costs: FloatArray = getattr(study.runs[name], f"{weights}_cost")
    return np.asarray(np.sort(costs) / _lowest(study, weights))


def _lowest(study: Study, weights: str) -> float:
    return min(float(np.min(getattr(run, f"{weights}_cost"))) for run in study.runs.values())


def sorted_values(study: Study, name: str) -> FloatArray:
    """Return an estimator's values over those of the best model, lowest user cost first, shape (S, P)."""
    run = study.runs[name]
    return np.asarray(run.values[np.argsort(run.user_cost)] / study.best.values)


def springs(study: Study) -> IntArray:
    """Return the indices of the springs among the parameters."""
    return np.flatnonzero([name.endswith(".stiffness") for name in study.problem.names])


def of_gears(study: Study) -> BoolArray:
    """Mark the parameters that belong to gears rather than to the structure of the arm, shape (P,)."""
    robot = study.problem.robot
    geared = {robot.arm_names[place] for place in robot.gear_rows}
    return np.array([name.rsplit(".", 1)[0] in geared for name in study.problem.names])


def hardest_spring(study: Study) -> int:
    """Return the index of the arm spring of the largest theoretical deviation, left out as in the paper."""
    candidates = [place for place in springs(study) if not of_gears(study)[place]] or list(springs(study))
    return int(max(candidates, key=lambda place: study.theory[place]))


def shares(study: Study) -> tuple[EstimatorShare, ...]:
    """Count the good models of every estimator."""
    every = springs(study)
    but_one = every[every != hardest_spring(study)]
    lowest = _lowest(study, "user")

    def small_enough(costs: FloatArray) -> BoolArray:
        return np.asarray(costs <= REASONABLE * lowest)

    found = []
    for kind in SIX:
        ratio, peers = sorted_values(study, kind.name), study.runs[kind.name].peer_cost
        within = (ratio >= 0.5) & (ratio <= 2.0)
        found.append(
            EstimatorShare(
                kind=kind,
                reasonable=float(np.mean(small_enough(study.runs[kind.name].user_cost))),
                peer=float(np.mean(small_enough(peers[~np.isnan(peers)]))),
                springs=float(np.mean(np.all(within[:, but_one], axis=1))),
                all_springs=float(np.mean(np.all(within[:, every], axis=1))),
                iterations=float(np.mean(study.runs[kind.name].iterations)),
            )
        )
    return tuple(found)


def table_1(study: Study) -> tuple[Statistics, ...]:
    """Return the statistics of every parameter among the best models of the reference estimator."""
    good = normalised_costs(study, REFERENCE) <= BEST
    ratio = sorted_values(study, REFERENCE)[good if np.any(good) else np.arange(len(good)) == 0]
    return tuple(
        Statistics(
            name=name,
            least=float(np.min(column)),
            median=float(np.median(column)),
            largest=float(np.max(column)),
            mean=float(np.mean(column)),
            deviation=float(np.std(column)),
            spread=float(study.spread[place]),
            theory=float(study.theory[place]),
            corrected=float(study.corrected[place]),
        )
        for place, (name, column) in enumerate(zip(study.problem.names, ratio.T, strict=True))
    )
