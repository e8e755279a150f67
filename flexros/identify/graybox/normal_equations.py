"""Cost, gradient and Gauss-Newton matrix of a fit with respect to the scaled parameters."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.identify.graybox.levenberg_marquardt import NormalEquations

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray, FloatArray
    from flexros.identify.graybox.frequency_model import FrequencyModel
    from flexros.identify.graybox.problem import GrayBoxProblem


def normal_equations(problem: GrayBoxProblem, model: FrequencyModel, values: FloatArray) -> NormalEquations:
    """Evaluate cost, gradient and Gauss-Newton matrix in plain NumPy.

    Args:
        problem: Measured responses, estimator and weights.
        model: Linearised robot.
        values: Values of the parameters [SI], shape (P,).

    Returns:
        Sum over w |e|^2, -2 sum Re(J^H w e) and 2 sum Re(J^H w J) with J = -de/dx.
    """
    response, jacobian = response_and_slopes(problem, model, values)
    used = problem.weights > 0
    weights = problem.weights[used]
    error = problem.estimator.error(problem.measured[used], response[used])
    slope = problem.estimator.slope(response[used], jacobian[used])
    weighted = weights[:, None] * slope
    gradient = -2.0 * np.real(weighted.conj().T @ error)
    hessian = 2.0 * np.real(weighted.conj().T @ slope)
    return NormalEquations(float(np.sum(weights * np.abs(error) ** 2)), gradient, hessian)


def response_and_slopes(
    problem: GrayBoxProblem, model: FrequencyModel, values: FloatArray
) -> tuple[ComplexArray, ComplexArray]:
    """Evaluate the model's responses and their derivatives with respect to the scaled parameters x.

    Args:
        problem: The scale of the parameters.
        model: Linearised robot.
        values: Values of the parameters [SI], shape (P,).

    Returns:
        Responses, shape (Q, F, M, M), and derivatives, shape (Q, F, M, M, P).
    """
    response, jacobian = model.response_and_jacobian(values)
    return response, jacobian * (problem.scale.per_value(values) / values)
