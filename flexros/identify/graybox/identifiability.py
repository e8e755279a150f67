"""Identifiability: parameters that the responses determine, and combinations that they do not."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from flexros.identify.graybox.covariance import NORMAL_95, ParameterCovariance, parameter_covariance

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray
    from flexros.identify.graybox.fit import GrayBoxFit
    from flexros.identify.graybox.problem import GrayBoxProblem

Verdict = Literal["determined", "weak", "not_determined"]

DETERMINED = 0.10
"""Largest standard deviation of a determined parameter, relative (chosen)."""

UNKNOWN = float(np.log(2.0)) / NORMAL_95
"""Standard deviation of a logarithm whose 95 % interval reaches a factor of 2 in both directions, 0.354."""

MEMBER = 0.2
"""Smallest component of a direction, relative to the largest, of a parameter that is named (chosen)."""


@dataclass(frozen=True)
class ParameterVerdict:
    """Identifiability of one parameter.

    Attributes:
        name: Name of the parameter.
        value: Fitted value [unit].
        unit: SI unit.
        relative: Standard deviation relative to the value; relative to its typical size if it is not logarithmic.
        interval: 95 % interval [unit].
        verdict: determined, weak or not_determined.
        reason: Reason of the verdict.
    """

    name: str
    value: float
    unit: str
    relative: float
    interval: tuple[float, float]
    verdict: Verdict
    reason: str


@dataclass(frozen=True)
class Direction:
    """A combination of parameters along which the responses hardly change.

    Attributes:
        exponents: Parameters and their exponents; the direction multiplies each by a common factor to this power.
        standard_deviation: Of the logarithm of that factor.
        determined: The best determined combination of the same parameters; empty if there is only one.
        determined_deviation: Standard deviation of the logarithm of that combination.
    """

    exponents: tuple[tuple[str, float], ...]
    standard_deviation: float
    determined: tuple[tuple[str, float], ...]
    determined_deviation: float

    @property
    def sentence(self) -> str:
        """The direction as a sentence."""
        spread = f"(standard deviation {_percent(self.standard_deviation)})"
        if not self.determined:
            return f"{self.exponents[0][0]} is not determined {spread}: the responses hardly depend on it."
        return (
            f"{_product(self.determined)} is determined to {_percent(self.determined_deviation)}, but not "
            f"{_product(self.exponents)} {spread}: a joint change of these parameters along that direction leaves the "
            "responses unchanged."
        )


@dataclass(frozen=True)
class Identifiability:
    """Identifiability of all parameters.

    Attributes:
        parameters: One verdict per parameter, in their order.
        directions: Combinations that are not determined.
    """

    parameters: tuple[ParameterVerdict, ...]
    directions: tuple[Direction, ...]

    def names(self, verdict: Verdict) -> tuple[str, ...]:
        """Return the names of the parameters with a verdict."""
        return tuple(parameter.name for parameter in self.parameters if parameter.verdict == verdict)


def identifiability(
    problem: GrayBoxProblem, fit: GrayBoxFit, covariance: ParameterCovariance | None = None
) -> Identifiability:
    """Judge which parameters are determined.

    Args:
        problem: Measured responses, estimator and weights.
        fit: Result of the fit.
        covariance: Covariance of the parameters; default: `parameter_covariance`.

    Returns:
        determined: standard deviation up to 10 %. not_determined: the 95 % interval reaches a factor of 2 or more, or
        the value is on a bound. weak: otherwise.
    """
    covariance = covariance or parameter_covariance(problem, fit)
    directions = _directions(fit.names, covariance.matrix)
    deviations, intervals = covariance.standard_deviation, covariance.intervals()
    verdicts = []
    for row, name in enumerate(fit.names):
        deviation = float(deviations[row])
        verdict, reason = _verdict(deviation, bool(fit.at_bound[row]))
        verdicts.append(
            ParameterVerdict(
                name=name,
                value=float(fit.values[row]),
                unit=problem.robot.parameters[name].unit,
                relative=deviation,
                interval=(float(intervals[row, 0]), float(intervals[row, 1])),
                verdict=verdict,
                reason=reason,
            )
        )
    return Identifiability(tuple(verdicts), directions)


def _verdict(deviation: float, at_bound: bool) -> tuple[Verdict, str]:
    spread = f"standard deviation {_percent(deviation)}"
    if at_bound:
        return "not_determined", f"the fit ended on a bound; {spread}"
    if deviation >= UNKNOWN:
        return "not_determined", f"{spread}: the 95 % interval reaches a factor of 2 or more in both directions"
    return ("determined" if deviation <= DETERMINED else "weak"), spread


def _directions(names: tuple[str, ...], matrix: FloatArray) -> tuple[Direction, ...]:
    """Find the directions with a standard deviation of `UNKNOWN` or more, each with as few parameters as possible."""
    variances, vectors = np.linalg.eigh(matrix)
    loose = vectors[:, variances >= UNKNOWN**2]
    directions = []
    for vector in _sparse_basis(loose):
        members = np.flatnonzero(np.abs(vector) >= MEMBER)
        deviation = float(np.sqrt(max(float(vector @ matrix @ vector), 0.0)) / (vector @ vector))
        determined, spread = _best_of(names, matrix, members)
        exponents = tuple((names[member], float(vector[member])) for member in members)
        directions.append(Direction(exponents, deviation, determined, spread))
    return tuple(directions)


def _sparse_basis(loose: FloatArray) -> list[FloatArray]:
    """Transform a basis, shape (P, k), so that every vector has one parameter of its own, with component 1."""
    rows = loose.T.copy()
    for k in range(len(rows)):
        rest = np.abs(rows[k:])
        row, column = divmod(int(np.argmax(rest)), rest.shape[1])
        rows[[k, k + row]] = rows[[k + row, k]]
        rows[k] /= rows[k, column]
        for other in range(len(rows)):
            if other != k:
                rows[other] -= rows[other, column] * rows[k]
    return [row / row[np.argmax(np.abs(row))] for row in rows]


def _best_of(
    names: tuple[str, ...], matrix: FloatArray, members: IntArray
) -> tuple[tuple[tuple[str, float], ...], float]:
    """Find the best determined combination of some parameters, its largest exponent 1, and its deviation."""
    if len(members) < 2:
        return (), np.inf
    _, vectors = np.linalg.eigh(matrix[np.ix_(members, members)])
    exponents = vectors[:, 0] / vectors[np.argmax(np.abs(vectors[:, 0])), 0]
    variance = float(exponents @ matrix[np.ix_(members, members)] @ exponents)
    named = tuple(
        (names[member], float(exponent)) for member, exponent in zip(members, exponents) if abs(exponent) >= MEMBER / 4
    )
    return named, float(np.sqrt(max(variance, 0.0)))


def _product(exponents: tuple[tuple[str, float], ...]) -> str:
    ordered = sorted(exponents, key=lambda factor: -abs(factor[1]))
    return " x ".join(name if abs(power - 1.0) < 5e-3 else f"{name}^{power:.2g}" for name, power in ordered)


def _percent(deviation: float) -> str:
    return f"{float(f'{100 * deviation:.2g}'):g} %" if deviation < 10 else "more than a factor of 1000"
