"""Weights of a fit: given by the user, optimal for the measured covariance, or both (Moberg 2007, Paper A, 5.1)."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Literal

import numpy as np
from pydantic import Field

from flexros.config.settings import Settings
from flexros.errors import InputError, unknown_name
from flexros.identify.frf.response_noise import response_noise

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.identify.frf.frequency_response import FrequencyResponse
    from flexros.identify.graybox.estimators import AbstractEstimator


class AbstractWeights(Settings, ABC):
    """Diagonal of the weighting matrix Lambda^-1 of every position and frequency.

    How to add a rule: a final subclass with a `kind` of its own that provides `array`.
    """

    lowest: float = Field(0.0, ge=0, description="no weight below this frequency [Hz], where the FRF is uncertain")
    highest: float | None = Field(None, gt=0, description="no weight above this frequency [Hz]; default: all lines")
    least_signal_to_noise: float = Field(
        10.0,
        description="no weight where |G| is not this much above its standard deviation [dB]: for logarithms, which are "
        "biased below 10 dB, line by line; for NLS with user weights, element by element",
    )

    @abstractmethod
    def array(self, responses: Sequence[FrequencyResponse], estimator: AbstractEstimator) -> FloatArray:
        """Compute the weights.

        Args:
            responses: Measured responses, one per position.
            estimator: Whose errors are weighted.

        Returns:
            Weights, shape (Q, F, n_y, n_u), index of position, frequency, output and input.

        Raises:
            InputError: A setting does not match the responses.
        """

    @abstractmethod
    def share_of_noise(self, weights: FloatArray, variance: FloatArray) -> FloatArray:
        """Return the share of 1 / weight that is measured variance, which is itself uncertain; the rest is constant.

        Args:
            weights: Weights, any shape.
            variance: Variance of each element of the errors, same shape.

        Returns:
            Shares, 0 to 1, same shape.
        """

    def in_band(self, responses: Sequence[FrequencyResponse]) -> FloatArray:
        """Return 1 for frequencies within the band and 0 outside, shape (Q, F, 1, 1)."""
        frequency = np.stack([response.frequency for response in responses])
        inside = (frequency >= self.lowest) & (frequency <= (np.inf if self.highest is None else self.highest))
        if not np.any(inside):
            raise InputError(
                f"the weights leave no frequency: lowest is {self.lowest:g} Hz, highest is "
                f"{'not set' if self.highest is None else f'{self.highest:g} Hz'}, but the responses reach from "
                f"{frequency.min():g} to {frequency.max():g} Hz; widen the band"
            )
        return inside[..., None, None].astype(float)

    def above_noise(self, responses: Sequence[FrequencyResponse], by_line: bool) -> FloatArray:
        """Return 1 where responses exceed their noise or the noise is not known, else 0.

        Args:
            responses: Responses, one per position.
            by_line: Whether to judge each line, or each element by its mean square over all lines.

        Returns:
            Shape (Q, F, n_y, n_u), or (Q, 1, n_y, n_u) for elements.
        """
        least = 10.0 ** (self.least_signal_to_noise / 10.0)
        masks = []
        for response in responses:
            noise, power = response_noise(response), np.abs(response.response) ** 2
            variance = np.zeros_like(power) if noise is None else noise.variance
            if not by_line:
                power, variance = power.mean(axis=0, keepdims=True), variance.mean(axis=0, keepdims=True)
            masks.append(power >= least * variance)
        return np.stack(masks).astype(float)


class UserWeights(AbstractWeights):
    """Constant for each element and the same for all positions, smaller off the diagonal (Moberg 2007, Paper A, 6).

    With logarithmic errors a constant weight already makes the fit match resonances and antiresonances. NLS weights
    absolute errors, so there the constants are divided by the mean square of the element's magnitude (chosen).
    Elements below the noise get weight 0: logarithms are biased below a signal-to-noise ratio of 10 dB (Pintelon and
    Schoukens 2001, p. 207).
    """

    kind: Literal["user"] = "user"
    diagonal: float = Field(1.0, ge=0, description="weight of motor i to motor i")
    off_diagonal: float = Field(0.2, ge=0, description="weight of motor i to motor j")
    elements: dict[str, float] = Field(
        default_factory=dict, description="weight of single elements, written output.input, e.g. motor_2.motor_1: 0.5"
    )

    def array(self, responses: Sequence[FrequencyResponse], estimator: AbstractEstimator) -> FloatArray:
        """Compute the weights; see `AbstractWeights.array`."""
        measured = np.stack([response.response for response in responses])
        weights = self.in_band(responses) * self._constants(responses[0])
        weights = weights * self.above_noise(responses, by_line=estimator.name != "NLS")
        if estimator.name == "NLS":
            used = weights > 0
            power = np.sum(np.abs(measured) ** 2 * used, axis=(0, 1)) / np.maximum(np.sum(used, axis=(0, 1)), 1)
            weights = weights / np.where(power > 0, power, 1.0)
        return weights

    def share_of_noise(self, weights: FloatArray, variance: FloatArray) -> FloatArray:
        """Return 0: the constants do not depend on the noise; see `AbstractWeights.share_of_noise`."""
        del variance
        return np.zeros_like(weights)

    def _constants(self, response: FrequencyResponse) -> FloatArray:
        outputs, inputs = response.output_names, response.input_names
        constants = np.full((len(outputs), len(inputs)), self.off_diagonal)
        np.fill_diagonal(constants, self.diagonal)
        elements = {f"{y}.{u}": (i, j) for i, y in enumerate(outputs) for j, u in enumerate(inputs)}
        for name, weight in self.elements.items():
            if name not in elements:
                raise unknown_name("element of the response", name, elements, "key elements of the weights")
            if weight < 0:
                raise InputError(f"key elements of the weights: {name} is {weight:g}, allowed is 0 or more; correct it")
            constants[elements[name]] = weight
        return constants


class OptimalWeights(AbstractWeights):
    """Inverse of the measured covariance, diagonal (Moberg 2007, Paper A, equations 6 and 8 with G_0 ~ G measured)."""

    kind: Literal["optimal"] = "optimal"

    def array(self, responses: Sequence[FrequencyResponse], estimator: AbstractEstimator) -> FloatArray:
        """Compute the weights; see `AbstractWeights.array`."""
        rows = [estimator.optimal_weight(_known_variance(response), response.response) for response in responses]
        clear = 1.0 if estimator.name == "NLS" else self.above_noise(responses, by_line=True)
        return self.in_band(responses) * np.stack(rows) * clear

    def share_of_noise(self, weights: FloatArray, variance: FloatArray) -> FloatArray:
        """Return 1; see `AbstractWeights.share_of_noise`."""
        del variance
        return np.ones_like(weights)


class CombinedWeights(AbstractWeights):
    """Inverse of measured covariance plus an allowed model-form error: w = 1 / (1 / w_user + 1 / w_optimal).

    Where the noise is small this is the user's weight, where it is large the optimal one, so no line needs to be
    excluded (chosen; Moberg 2007, Paper A, section 7 names such a combination as future work). Lines whose noise is far
    below the accuracy of a linear model of a nonlinear robot do not dominate the fit, so that intervals stay realistic.
    """

    kind: Literal["combined"] = "combined"
    diagonal: float = Field(0.02, gt=0, description="allowed model-form error, relative to |G|, motor i to motor i")
    off_diagonal: float = Field(0.04, gt=0, description="the same, motor i to motor j")

    def array(self, responses: Sequence[FrequencyResponse], estimator: AbstractEstimator) -> FloatArray:
        """Compute the weights; see `AbstractWeights.array`."""
        user = UserWeights(
            lowest=self.lowest,
            highest=self.highest,
            diagonal=self.diagonal**-2,
            off_diagonal=self.off_diagonal**-2,
            least_signal_to_noise=self.least_signal_to_noise,
        ).array(responses, estimator)
        optimal = OptimalWeights(least_signal_to_noise=self.least_signal_to_noise).array(responses, estimator)
        used = (user > 0) & (optimal > 0)
        inverse = 1.0 / np.where(used, user, 1.0) + 1.0 / np.where(used, optimal, 1.0)
        return np.where(used, 1.0 / inverse, 0.0)

    def share_of_noise(self, weights: FloatArray, variance: FloatArray) -> FloatArray:
        """Return w / w_optimal; see `AbstractWeights.share_of_noise`."""
        return np.clip(weights * variance, 0.0, 1.0)


Weights = UserWeights | OptimalWeights | CombinedWeights


def weights_named(kind: str, source: str = "") -> Weights:
    """Return the weights of a kind with their default settings.

    Args:
        kind: "user", "optimal" or "combined".
        source: Where the name came from; part of the error text.

    source: Origin of the name, for the error message.
        InputError: There are no weights of this kind.
    """
    known: dict[str, type[Weights]] = {"user": UserWeights, "optimal": OptimalWeights, "combined": CombinedWeights}
    if kind not in known:
        raise unknown_name("kind of weights", kind, known, source)
    return known[kind]()


def _known_variance(response: FrequencyResponse) -> FloatArray:
    noise = response_noise(response)
    if noise is None:
        raise InputError(
            "optimal weights need the covariance of the frequency responses, but the one at gear angles "
            f"{np.round(response.gears, 4).tolist()} has none; record two blocks or two periods, or use user weights"
        )
    return noise.variance
