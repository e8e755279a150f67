"""Covariance of the fitted parameters from that of the measured responses (Moberg 2007, Paper A, equation 5)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from flexros.identify.frf.response_noise import response_noise

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flexros.arrays import ComplexArray, FloatArray
    from flexros.identify.frf.response_noise import ResponseNoise
    from flexros.identify.graybox.fit import GrayBoxFit
    from flexros.identify.graybox.parameter_scale import ParameterScale
    from flexros.identify.graybox.problem import GrayBoxProblem

Number = TypeVar("Number", np.float64, np.complex128)

NORMAL_95 = 1.959964
"""Half width of a 95 % interval in standard deviations."""

NOTHING_KNOWN = 1e3
"""Standard deviation of a scaled parameter on which no response depends (represents infinity)."""

MISSES = 1.3
"""Reduced cost from which a model-form error is reported; below it, scatter explains the difference (chosen)."""

FORM_ERROR = "because of a model-form error"
"""Cause of a large reduced cost in `ParameterCovariance.explanation`."""

NULL = 1e-13
"""Eigenvalues of the normalised information below this share of the largest are rounding errors (chosen)."""

LOST = 1.0
"""Relative variance from which the first-order variance of a logarithm is meaningless (chosen)."""

_TINY = float(np.finfo(float).tiny)


@dataclass(frozen=True, eq=False)
class ParameterCovariance:
    """First-order covariance of fitted parameters.

    Attributes:
        scale: The scaled parameters x: logarithms, or multiples of a typical size.
        values: Fitted values [SI], shape (P,).
        matrix: Covariance of x, after the corrections, shape (P, P).
        basis: Source of the covariance of the responses: "total" (blocks), "noise" (periods), or "residuals".
        reduced_cost: Cost over its value expected from that covariance; 1 where the model explains all but noise.
        factor: Factor applied to (5), mean over all parameters: `reduced_cost` if larger than 1, times the inflation
            due to weights that were themselves estimated from few degrees of freedom.
        explanation: One sentence on basis and factor.
    """

    scale: ParameterScale
    values: FloatArray
    matrix: FloatArray
    basis: str
    reduced_cost: float
    factor: float
    explanation: str

    @property
    def standard_deviation(self) -> FloatArray:
        """Standard deviation of x: relative for logarithmic parameters, in typical sizes else, shape (P,)."""
        return np.sqrt(np.maximum(np.diag(self.matrix), 0.0))

    @property
    def relative(self) -> FloatArray:
        """Standard deviation relative to the value, shape (P,); infinite for a value of zero."""
        absolute = self.standard_deviation * self.scale.per_value(self.values)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(np.where(self.values == 0, np.inf, np.abs(absolute / self.values)))

    def intervals(self, width: float = NORMAL_95) -> FloatArray:
        """Return intervals of the values, symmetric in x.

        Args:
            width: Half width in standard deviations; default: 95 %.

        Returns:
            Lower and upper ends [SI], shape (P, 2).
        """
        x, reach = self.scale.scaled(self.values), width * self.standard_deviation
        with np.errstate(over="ignore"):
            return np.stack([self.scale.values(x - reach), self.scale.values(x + reach)], axis=1)


def parameter_covariance(problem: GrayBoxProblem, fit: GrayBoxFit, correct: bool = True) -> ParameterCovariance:
    """Evaluate (5) with the full covariance of the responses.

    Logarithms of elements below the noise have no first-order variance: lines in a notch of the model make (5) far too
    large. Weights from the measured magnitudes admit some of them; the weights of `GrayBoxProblem.reweighted`, which
    `refine` uses, admit none.

    Args:
        problem: Measured responses, estimator and weights.
        fit: Result of the fit.
        correct: Whether to correct (5), see `ParameterCovariance.factor`; (5) itself holds for known covariances and a
            model without model-form error.

    Returns:
        The covariance. Where no covariance of the responses is known, it is the inverse of the weights up to a factor
        that is estimated from the residuals.
    """
    noises = [noise for noise in map(response_noise, problem.responses) if noise is not None]
    model = problem.model_at(fit.values)
    response, jacobian = model.response_and_jacobian(fit.values, problem.scale.per_value(fit.values))
    if len(noises) < len(problem.responses):
        return _from_residuals(problem, fit, _sums(problem, response, jacobian, []))
    sums = _sums(problem, response, jacobian, noises)
    inverse, unknown = _inverse(sums.information)
    plain, grown = (0.5 * inverse @ spread @ inverse for spread in (sums.spread, sums.grown_spread))
    expected = sums.expected_cost - float(np.trace(sums.information @ grown))
    inflation = float(np.trace(sums.information @ grown) / max(np.trace(sums.information @ plain), _TINY))
    reduced = fit.cost / max(expected, _TINY)
    matrix, factor = plain, 1.0
    if correct:
        matrix, factor = max(reduced, 1.0) * grown, max(reduced, 1.0) * inflation
    text = _explanation(reduced, inflation, factor, correct) + _lost(problem, response, noises)
    return ParameterCovariance(problem.scale, fit.values, matrix + unknown, noises[0].kind, reduced, factor, text)


@dataclass(frozen=True, eq=False)
class _Sums:
    """Sums over positions and frequencies.

    Attributes:
        information: sum Re(J^H W J), shape (P, P).
        spread: sum Re(J^H W L W J), shape (P, P).
        grown_spread: The same, increased for uncertain weights.
        expected_cost: Expected cost at the true parameters, increased for uncertain weights.
        count: Number of elements with a weight.
    """

    information: FloatArray
    spread: FloatArray
    grown_spread: FloatArray
    expected_cost: float
    count: int


def _sums(
    problem: GrayBoxProblem, response: ComplexArray, jacobian: ComplexArray, noises: list[ResponseNoise]
) -> _Sums:
    n, estimator = jacobian.shape[-1], problem.estimator
    information, spread, grown, expected = np.zeros((n, n)), np.zeros((n, n)), np.zeros((n, n)), 0.0
    for position, (modelled, slopes, weights) in enumerate(zip(response, jacobian, problem.weights, strict=True)):
        stacked, w = _stack(modelled), _stack(weights)
        J = np.where((w > 0)[..., None], estimator.slope(stacked, _stack(slopes)), 0.0)
        weighted = w[..., None] * J
        information += np.real(np.tensordot(J.conj(), weighted, ((0, 1), (0, 1))))
        if noises:
            L = estimator.error_covariance(noises[position].covariance(), stacked)
            variance = np.einsum("fmm->fm", L).real
            share = problem.setting.share_of_noise(w, variance)
            growth, excess = _of_estimated_weights(share, noises[position].degrees_of_freedom)
            wider = weighted * np.sqrt(growth)[..., None]
            spread += np.real(np.tensordot(weighted.conj(), L @ weighted, ((0, 1), (0, 1))))
            grown += np.real(np.tensordot(wider.conj(), L @ wider, ((0, 1), (0, 1))))
            expected += estimator.noise_share * float(np.sum(w * excess * variance))
    return _Sums(information, spread, grown, expected, int(np.count_nonzero(problem.weights)))


def _lost(problem: GrayBoxProblem, response: ComplexArray, noises: list[ResponseNoise]) -> str:
    """Report how many weighted elements have a modelled magnitude below its standard deviation."""
    if problem.estimator.name == "NLS":  # errors are linear in the responses
        return ""
    variance = np.stack([noise.variance for noise in noises])
    counted = problem.weights > 0
    lost = int(np.count_nonzero(counted & (problem.estimator.element_variance(variance, response) > LOST)))
    if not lost:
        return ""
    return (
        f" {lost} of {np.count_nonzero(counted)} elements are modelled below their noise, so that this is too large: "
        "weights were computed from the measured responses."
    )


def _from_residuals(problem: GrayBoxProblem, fit: GrayBoxFit, sums: _Sums) -> ParameterCovariance:
    """Scale the inverse of the weights by the residuals."""
    inverse, unknown = _inverse(sums.information)
    degrees = max(problem.estimator.noise_share * sums.count - 0.5 * len(fit.names), 1.0)
    matrix = 0.5 * fit.cost / degrees * inverse + unknown
    text = "The responses have no covariance; it was estimated from the residuals."
    return ParameterCovariance(problem.scale, fit.values, matrix, "residuals", 1.0, 1.0, text)


def _stack(elements: NDArray[Number]) -> NDArray[Number]:
    """Stack the columns of (F, n_y, n_u, ...), shape (F, n_u n_y, ...), as vec does."""
    swapped = np.swapaxes(elements, 1, 2)
    return swapped.reshape(len(swapped), -1, *swapped.shape[3:])


def _inverse(information: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Invert without the null directions; return the inverse and the covariance of the null directions."""
    size = np.sqrt(np.diag(information))
    size = np.where(size > 0, size, np.max(size, initial=0.0) or 1.0)
    eigenvalues, vectors = np.linalg.eigh(information / np.outer(size, size))
    seen = eigenvalues > NULL * eigenvalues[-1]
    directions = vectors / size[:, None]
    inverse = (directions[:, seen] / eigenvalues[seen]) @ directions[:, seen].T
    blind = directions[:, ~seen] / np.linalg.norm(directions[:, ~seen], axis=0)
    return inverse, NOTHING_KNOWN**2 * blind @ blind.T


def _of_estimated_weights(share: FloatArray, degrees: float) -> tuple[FloatArray, FloatArray]:
    """Growth of covariance and of expected cost with weights from variances of few degrees of freedom.

    With v = s chi^2 / (2 nu) as the estimate of a variance s, E[1/v] = nu / (nu - 1) / s and
    E[1/v^2] = nu^2 / ((nu - 1)(nu - 2)) / s^2. Then (5), which treats both as exact, is too small by nu / (nu - 2), and
    the cost is too small by nu / (nu - 1) where the weight is 1 / v. Where v is the share r of 1 / w, both exceed 1 by
    r times as much, to first order in 1 / nu (derived).

    Args:
        share: r, any shape.
        degrees: nu.
    """
    steady = max(degrees, 3.0)
    return 1.0 + 2.0 * share / (steady - 2.0), 1.0 + share / (steady - 1.0)


def _explanation(reduced: float, inflation: float, factor: float, correct: bool) -> str:
    text = f"The cost is {reduced:.3g} times what the covariance of the responses explains"
    if not correct:
        return f"{text}; nothing was corrected."
    causes = []
    if reduced >= MISSES:
        causes.append(f"by this, {FORM_ERROR}")
    elif reduced > 1:
        causes.append("by this, which is within what scatter explains")
    if inflation > 1:
        causes.append(f"by {inflation:.3g}, because the weights come from few blocks")
    if not causes:
        return f"{text}; the parameter covariance is that of the responses alone."
    whole = f" by {factor:.3g}:" if len(causes) > 1 else ""
    return f"{text}; the parameter covariance was multiplied{whole} {', and '.join(causes)}."
