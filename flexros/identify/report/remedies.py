"""Further experiments that would determine what is not determined yet."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.identify.design.experiment_design import PRIOR_DEVIATION
from flexros.identify.design.information import frf_information
from flexros.identify.design.next_experiment import most_telling_frequency, next_experiment
from flexros.identify.design.position_information import frequency_information
from flexros.identify.frf.response_noise import response_noise
from flexros.identify.graybox.covariance import parameter_covariance

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.identify.result import IdentificationResult

MOST = 8
"""Combinations for which an experiment is looked for (chosen)."""


@dataclass(frozen=True, eq=False)
class Remedy:
    """The best single further experiment for a combination of parameters.

    Attributes:
        what: The combination, in words.
        gears: Gear coordinates of the position [rad or m], shape (M,).
        position: Number of the position among those measured already, 0-based; None where it was not.
        frequency: Most informative frequency [Hz].
        now: Standard deviation of the combination now [1].
        optimal: Its value with optimal weights of the same responses [1] (Moberg 2007, Paper A, eq. 6 and 8).
        gain: Factor by which the smallest possible standard deviation falls with the further experiment, at most 1.
    """

    what: str
    gears: FloatArray
    position: int | None
    frequency: float
    now: float
    optimal: float
    gain: float


@dataclass(frozen=True, eq=False)
class _Candidates:
    """Positions for a further experiment.

    Attributes:
        information: Information of an experiment in each, shape (C, P, P).
        gears: Gear coordinates [rad or m], shape (C, M); NaN where they are not known.
        positions: Number of the measured position that each is; None where it was not measured.
    """

    information: FloatArray
    gears: FloatArray
    positions: tuple[int | None, ...]


def remedies(result: IdentificationResult) -> tuple[Remedy, ...]:
    """Find experiments for all combinations that are not determined, and for weak parameters.

    Candidates are those of the design, else the measured positions. The information of the design is scaled to that of
    the measured responses, so that their errors beyond encoder noise count as well.

    Args:
        result: The identification.

    Returns:
        One remedy per combination; none where the responses have no covariance.
    """
    wanted = _wanted(result)[:MOST]
    if not wanted or any(response_noise(response) is None for response in result.problem.responses):
        return ()
    by_line = measured_information(result)
    given = by_line.sum(axis=(0, 1))
    candidates = _candidates(result, by_line)
    total = given + np.eye(len(given)) / PRIOR_DEVIATION**2
    weighted = result.problem.with_choice(result.fit.estimator, "optimal").reweighted(result.fit.values)
    optimal = parameter_covariance(weighted, result.fit, correct=False).matrix
    best_experiments = []
    for what, direction in wanted:
        best = next_experiment(total, candidates.information, direction)
        position = candidates.positions[best.candidate]
        if position is None:
            frequency, lines = _designed_lines(result, best.candidate)
        else:
            frequency, lines = result.problem.frequency, by_line[position]
        line = most_telling_frequency(lines, total + candidates.information[best.candidate], direction)
        best_experiments.append(
            Remedy(
                what=what,
                gears=candidates.gears[best.candidate],
                position=position,
                frequency=float(frequency[line]),
                now=float(np.sqrt(direction @ result.covariance.matrix @ direction)),
                optimal=float(np.sqrt(direction @ optimal @ direction)),
                gain=best.after / best.before,
            )
        )
    return tuple(best_experiments)


def measured_information(result: IdentificationResult) -> FloatArray:
    """Compute the information of the measured responses line by line, from their own covariance.

    Args:
        result: The identification.

    Returns:
        Information about the scaled parameters, shape (Q, F, P, P).
    """
    problem = result.problem
    model = problem.model_at(result.fit.values)
    _, jacobian = model.response_and_jacobian(result.fit.values, problem.scale.per_value(result.fit.values))
    parts = []
    for slopes, response in zip(jacobian, problem.responses, strict=True):
        noise = response_noise(response)
        assert noise is not None
        spectrum = np.asarray(np.linalg.cholesky(np.linalg.inv(noise.input_inverse)), dtype=complex)
        parts.append(frf_information(slopes, spectrum, np.einsum("fii->fi", noise.error).real))
    return np.array(parts)


def _wanted(result: IdentificationResult) -> list[tuple[str, FloatArray]]:
    """List the combinations in words and as directions of the scaled parameters."""
    names = list(result.fit.names)
    wanted = []
    for each in result.identifiability.directions:
        direction = np.zeros(len(names))
        for name, exponent in each.exponents:
            direction[names.index(name)] = exponent
        wanted.append((" and ".join(name for name, _ in each.exponents), direction / np.linalg.norm(direction)))
    listed = {what for what, _ in wanted}
    for entry in result.identifiability.parameters:
        if entry.verdict != "determined" and not any(entry.name in what.split(" and ") for what in listed):
            wanted.append((entry.name, np.eye(len(names))[names.index(entry.name)]))
    return wanted


def _ratio(given: FloatArray, promised: FloatArray) -> float:
    """Compare two information matrices by the P-th root of the ratio of their determinants."""
    (sign, value), (other_sign, other) = (np.linalg.slogdet(matrix) for matrix in (given, promised))
    if sign <= 0 or other_sign <= 0:
        return float(np.trace(given) / np.trace(promised))
    return float(np.exp((value - other) / len(given)))


def _candidates(result: IdentificationResult, measured: FloatArray) -> _Candidates:
    """Return the candidates of the design, or the measured positions where there is no design for these parameters."""
    gears = np.array([each.gears for each in result.problem.responses])
    design = result.design
    if design is None or not has_candidates(result):
        return _Candidates(measured.sum(axis=1), gears, tuple(range(len(gears))))
    information = _ratio(measured.sum(axis=(0, 1)), design.information) * design.design.information
    same = [np.all(np.isclose(gears, each), axis=1) for each in design.candidates.gears]
    positions = tuple(int(np.argmax(each)) if np.any(each) else None for each in same)
    return _Candidates(information, design.candidates.gears, positions)


def has_candidates(result: IdentificationResult) -> bool:
    """Whether there is a design for the fitted parameters, from which further positions can be chosen."""
    return result.design is not None and result.design.names == result.fit.names


def _designed_lines(result: IdentificationResult, candidate: int) -> tuple[FloatArray, FloatArray]:
    """Return frequencies and information line by line of a candidate of the design."""
    design = result.design
    assert design is not None
    motors = design.candidates.motor_positions[[candidate]]
    robot = result.problem.robot
    lines = frequency_information(robot, design.names, motors, design.conditions, design.law, design.sample_time)
    return design.conditions.frequency, lines[0]
