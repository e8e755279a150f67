"""Weighted least squares of frequency responses with diagonal weights (Moberg 2007, Paper A, equations 4 and 7)."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.identify.graybox.estimators import estimator_named
from flexros.identify.graybox.kernel.structure import packed_target
from flexros.prediction.damped_least_squares import NormalEquations

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray, FloatArray
    from flexros.identify.graybox.frequency_model import FrequencyModel


@dataclass(frozen=True, eq=False)
class ResponseTarget:
    """Measured responses of a fit with their weights.

    Attributes:
        response: Torque command -> motor acceleration, shape (Q, F, M, M); arbitrary where the weight is zero.
        weights: Weights of the squared errors, 0 for excluded elements, shape (Q, F, M, M).
        estimator: "LLS", "LLSM" or "NLS".
    """

    response: ComplexArray
    weights: FloatArray
    estimator: str

    @cached_property
    def packed(self) -> FloatArray:
        """The target in the order of the compiled code, see `packed_target`; packed once for all linearisations."""
        return packed_target(self.response, self.weights, logarithmic=self.estimator != "NLS")

    def check(self, model: FrequencyModel) -> None:
        """Check the target against its model.

        Raises:
            InputError: Unknown estimator, wrong shapes, negative weights, or values that are not finite.
        """
        estimator_named(self.estimator)
        n_motors = len(model.positions.motor_rows)
        shape = (len(model.positions.mass), model.frequency.shape[-1], n_motors, n_motors)
        for what, array in (("measured responses", self.response), ("weights", self.weights)):
            if array.shape != shape:
                raise InputError(
                    f"{what} have shape {array.shape}, but the model of robot {model.positions.robot_name} needs "
                    f"{shape} (positions, frequencies, motors, motors); correct them"
                )
        counted = self.weights != 0
        if not np.all(np.isfinite(self.weights)) or np.any(self.weights < 0):
            raise InputError("weights of frequency responses must be finite and not negative; correct them")
        usable = np.isfinite(self.response) & ((self.response != 0) | (self.estimator == "NLS"))
        if np.any(counted & ~usable):
            raise InputError(
                f"{np.count_nonzero(counted & ~usable)} elements of the measured responses are zero or not finite "
                "but have a weight; set their weights to zero"
            )


class AbstractLeastSquares(ABC):
    """Sum of weight times squared magnitude of the errors of one estimator, as function of the parameters.

    How to add an implementation: provide `cost` and `normal_equations`.
    """

    @abstractmethod
    def cost(self, theta: FloatArray) -> float:
        """Evaluate the cost, infinite or NaN where the model fails, for values of the parameters (SI), shape (P,)."""

    @abstractmethod
    def normal_equations(self, theta: FloatArray, scale: FloatArray | None = None) -> NormalEquations:
        """Evaluate cost, gradient and Gauss-Newton Hessian with respect to scaled parameters x.

        Args:
            theta: Values of the parameters (SI), shape (P,).
            scale: dtheta/dx, shape (P,); default: theta, so that x is the logarithm.

        Returns:
            The quadratic model of the cost about theta.
        """


@dataclass(frozen=True, eq=False)
class NumpyLeastSquares(AbstractLeastSquares):
    """The sum in plain NumPy, for all kinds of parameters.

    Attributes:
        model: Frequency model.
        target: Measured responses and weights.
    """

    model: FrequencyModel
    target: ResponseTarget

    def cost(self, theta: FloatArray) -> float:
        """Evaluate the cost; see `AbstractLeastSquares.cost`."""
        error = self._error(self.model.response(theta))
        return float(np.sum(self.target.weights * np.abs(error) ** 2))

    def normal_equations(self, theta: FloatArray, scale: FloatArray | None = None) -> NormalEquations:
        """Evaluate the normal equations; see `AbstractLeastSquares.normal_equations`."""
        response, jacobian = self.model.response_and_jacobian(theta, scale)
        error = self._error(response)
        weights = self.target.weights
        counted = weights > 0
        slope = estimator_named(self.target.estimator).slope(np.where(counted, response, 1.0), jacobian)
        columns = (slope * np.sqrt(weights)[..., None]).reshape(-1, jacobian.shape[-1])
        weighted = (error * np.sqrt(weights)).ravel()
        return NormalEquations(
            cost=float(np.sum(np.abs(weighted) ** 2)),
            gradient=-2.0 * np.real(columns.conj().T @ weighted),
            hessian=2.0 * np.real(columns.conj().T @ columns),
        )

    def _error(self, response: ComplexArray) -> ComplexArray | FloatArray:
        counted = self.target.weights > 0
        measured = np.where(counted, self.target.response, 1.0)
        return estimator_named(self.target.estimator).error(measured, np.where(counted, response, 1.0))
