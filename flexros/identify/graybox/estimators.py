"""Errors that a fit of frequency responses minimises: NLS, LLS, LLS of magnitudes (Moberg 2007, Paper A, 5.1)."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.errors import unknown_name

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray, FloatArray


class AbstractEstimator(ABC):
    """An error between measured and modelled responses; the cost is the sum of weight times squared magnitude.

    How to add an estimator: provide `name`, `error`, `slope`, `error_covariance` and `noise_share`. With the errors e
    of one frequency stacked, W the weights, J = -de/dx and L = `error_covariance`, the parameters x have the covariance
    (Moberg 2007, Paper A, equation 5, there written with Xi and Sigma, per N_f)

        P = 1/2 [sum Re(J^H W J)]^-1 [sum Re(J^H W L W J)] [sum Re(J^H W J)]^-1.
    """

    name: ClassVar[str]

    noise_share: ClassVar[float]
    """Mean of |e|^2 over the diagonal of `error_covariance`: 1 for complex errors, 1/2 where the real part counts."""

    @abstractmethod
    def error(self, measured: ComplexArray, response: ComplexArray) -> ComplexArray | FloatArray:
        """Compute the error E (Moberg 2007, Paper A, equations 4c and 7c).

        Args:
            measured: Measured responses, any shape.
            response: Responses of the model, same shape.

        Returns:
            Errors, same shape; real where only magnitudes are compared.
        """

    @abstractmethod
    def slope(self, response: ComplexArray, jacobian: ComplexArray) -> ComplexArray | FloatArray:
        """Compute J = -dE/dx.

        Args:
            response: Responses of the model, shape (...).
            jacobian: Their derivatives with respect to the parameters x, shape (..., P).

        Returns:
            Derivatives, shape (..., P).
        """

    @abstractmethod
    def error_covariance(self, covariance: ComplexArray, response: ComplexArray) -> ComplexArray | FloatArray:
        """Propagate the covariance of the measured responses to the errors, to first order.

        Args:
            covariance: Lambda_0, shape (..., m, m), with m stacked elements of the response.
            response: The stacked elements, shape (..., m).

        Returns:
            Covariance L such that the errors' (co)variance is `noise_share` L, shape (..., m, m).
        """

    def optimal_weight(self, variance: FloatArray, response: ComplexArray) -> FloatArray:
        """Compute the diagonal of the optimal weights (Moberg 2007, Paper A, equations 6 and 8).

        Args:
            variance: Variance of each element of the measured responses, any shape.
            response: The elements, same shape.

        Returns:
            Weights, same shape; zero where the variance is zero or not finite.
        """
        scaled = self.element_variance(variance, response)
        known = np.isfinite(scaled) & (scaled > 0)
        return np.where(known, 1.0 / np.where(known, scaled, 1.0), 0.0)

    @abstractmethod
    def element_variance(self, variance: FloatArray, response: ComplexArray) -> FloatArray:
        """Propagate variances of single elements to the errors: the diagonal of `error_covariance`.

        Args:
            variance: Variance of each element of the measured responses, any shape.
            response: The elements, same shape.

        Returns:
            Diagonal of L, same shape.
        """


class NonlinearLeastSquares(AbstractEstimator):
    """NLS: E = G_measured - G_model."""

    name = "NLS"
    noise_share = 1.0

    def error(self, measured: ComplexArray, response: ComplexArray) -> ComplexArray:
        """Return the difference; see `AbstractEstimator.error`."""
        return measured - response

    def slope(self, response: ComplexArray, jacobian: ComplexArray) -> ComplexArray:
        """Return the Jacobian itself; see `AbstractEstimator.slope`."""
        del response
        return jacobian

    def error_covariance(self, covariance: ComplexArray, response: ComplexArray) -> ComplexArray:
        """Return the covariance itself; see `AbstractEstimator.error_covariance`."""
        del response
        return covariance

    def element_variance(self, variance: FloatArray, response: ComplexArray) -> FloatArray:
        """Return the variance itself; see `AbstractEstimator.element_variance`."""
        del response
        return variance


class LogarithmicLeastSquares(AbstractEstimator):
    """LLS: E = log G_measured - log G_model with log G = log|G| + j arg G, the angle taken within (-pi, pi]."""

    name = "LLS"
    noise_share = 1.0

    def error(self, measured: ComplexArray, response: ComplexArray) -> ComplexArray:
        """Return the difference of logarithms; see `AbstractEstimator.error`."""
        error: ComplexArray = np.log(measured / response)
        return error

    def slope(self, response: ComplexArray, jacobian: ComplexArray) -> ComplexArray:
        """Return the relative Jacobian; see `AbstractEstimator.slope`."""
        relative: ComplexArray = jacobian / response[..., None]
        return relative

    def error_covariance(self, covariance: ComplexArray, response: ComplexArray) -> ComplexArray:
        """Return G_d^-1 Lambda_0 G_d^-H with G_d = diag(vec G); see `AbstractEstimator.error_covariance`."""
        relative: ComplexArray = covariance / (response[..., :, None] * response[..., None, :].conj())
        return relative

    def element_variance(self, variance: FloatArray, response: ComplexArray) -> FloatArray:
        """Return the relative variance; see `AbstractEstimator.element_variance`."""
        relative: FloatArray = variance / np.abs(response) ** 2
        return relative


class LogMagnitudeLeastSquares(AbstractEstimator):
    """LLSM: E = log|G_measured| - log|G_model|.

    For circular noise n, log|G + n| - log|G| = Re(n / G) to first order, whose covariance is half the real part of
    that of n / G. So P has the same form as for LLS with J and L replaced by their real parts (derived).
    """

    name = "LLSM"
    noise_share = 0.5

    def error(self, measured: ComplexArray, response: ComplexArray) -> FloatArray:
        """Return the difference of logarithms of magnitudes; see `AbstractEstimator.error`."""
        error: FloatArray = np.log(np.abs(measured) / np.abs(response))
        return error

    def slope(self, response: ComplexArray, jacobian: ComplexArray) -> FloatArray:
        """Return the real part of the relative Jacobian; see `AbstractEstimator.slope`."""
        relative: FloatArray = np.real(jacobian / response[..., None])
        return relative

    def error_covariance(self, covariance: ComplexArray, response: ComplexArray) -> FloatArray:
        """Return Re(G_d^-1 Lambda_0 G_d^-H); see `AbstractEstimator.error_covariance`."""
        relative: FloatArray = np.real(covariance / (response[..., :, None] * response[..., None, :].conj()))
        return relative

    def element_variance(self, variance: FloatArray, response: ComplexArray) -> FloatArray:
        """Return the relative variance; see `AbstractEstimator.element_variance`."""
        relative: FloatArray = variance / np.abs(response) ** 2
        return relative


ESTIMATORS: dict[str, AbstractEstimator] = {
    estimator.name: estimator
    for estimator in (LogarithmicLeastSquares(), LogMagnitudeLeastSquares(), NonlinearLeastSquares())
}
"""The estimators by name."""


def estimator_named(name: str, source: str = "") -> AbstractEstimator:
    """Find an estimator.

    Args:
        name: "LLS", "LLSM" or "NLS".
        source: Origin of the name, for the error message.

    Raises:
        InputError: There is no estimator of this name.
    """
    if name not in ESTIMATORS:
        raise unknown_name("estimator", name, ESTIMATORS, source)
    return ESTIMATORS[name]
