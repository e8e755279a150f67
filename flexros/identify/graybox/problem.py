"""One gray-box identification: measured responses, unknown parameters, estimator and weights."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.errors import InputError
from flexros.identify.graybox.estimators import AbstractEstimator, estimator_named
from flexros.identify.graybox.frequency_model import FrequencyModel
from flexros.identify.graybox.least_squares import ResponseTarget
from flexros.identify.graybox.parameter_scale import ParameterScale, parameter_scale
from flexros.identify.graybox.weights import Weights, weights_named
from flexros.robot.linear.positions import linearise_positions
from flexros.robot.robot import robot_from_data

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import ComplexArray, FloatArray
    from flexros.identify.frf.frequency_response import FrequencyResponse
    from flexros.robot.robot import Robot


@dataclass(frozen=True, eq=False)
class GrayBoxProblem:
    """Data of a fit, created by `graybox_problem`; can be sent to other processes.

    Attributes:
        robot: The robot with its nominal values.
        scale: The unknown parameters and their scaling.
        responses: Measured torque-to-acceleration responses, one per position, on common frequencies.
        estimator: Estimator whose cost is minimised.
        setting: Rule by which the weights were computed.
        weights: Weights, shape (Q, F, M, M).
        model: Frequency model linearised at the nominal values.
    """

    robot: Robot
    scale: ParameterScale
    responses: tuple[FrequencyResponse, ...]
    estimator: AbstractEstimator
    setting: Weights
    weights: FloatArray
    model: FrequencyModel

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the unknown parameters, length P."""
        return self.scale.names

    @property
    def frequency(self) -> FloatArray:
        """Frequencies [Hz], shape (F,)."""
        return self.responses[0].frequency

    @property
    def measured(self) -> ComplexArray:
        """Measured responses [(rad/s2)/Nm, or the like], shape (Q, F, M, M)."""
        return np.stack([response.response for response in self.responses])

    @cached_property
    def target(self) -> ResponseTarget:
        """Measured responses, weights and estimator of the search; computed once for all fits of the problem."""
        return ResponseTarget(self.measured, self.weights, self.estimator.name)

    def model_at(self, values: FloatArray) -> FrequencyModel:
        """Linearise the robot at the equilibria of given parameter values (Moberg 2007, Paper A, remark A.1).

        Args:
            values: Values of the unknown parameters [SI], shape (P,).

        Raises:
            InputError: With these values the robot has no equilibrium in one of the positions.
        """
        return _frequency_model(self.robot, self.names, self.responses, values)

    def with_choice(self, estimator: str, weights: Weights | str) -> GrayBoxProblem:
        """Return the same problem with another estimator and other weights; responses and linearisation are shared."""
        chosen, setting = estimator_named(estimator), weights_named(weights) if isinstance(weights, str) else weights
        array = _weight_array(setting, self.responses, chosen)
        return GrayBoxProblem(self.robot, self.scale, self.responses, chosen, setting, array, self.model)

    def reweighted(self, values: FloatArray) -> GrayBoxProblem:
        """Return the same problem with weights from the model's responses instead of the measured ones.

        (8) of Moberg (2007, Paper A) requires the true response. Near the end of an identification the model is closer
        to it than the measurement, and weights that do not depend on the noise of the same lines leave no bias.

        Args:
            values: Values of the unknown parameters [SI], shape (P,).
        """
        modelled = self.with_modelled(self.model_at(values).response(values))
        return replace(self, weights=_weight_array(self.setting, modelled, self.estimator))

    def with_modelled(self, modelled: ComplexArray) -> tuple[FrequencyResponse, ...]:
        """Replace the measured responses by modelled ones and keep the measured covariance.

        Args:
            modelled: Responses of a model, shape (Q, F, M, M).

        Returns:
            One response per position.
        """
        return tuple(replace(given, response=model) for given, model in zip(self.responses, modelled, strict=True))

    def __reduce__(self) -> tuple[Any, ...]:
        robot = (self.robot.spec.model_dump(mode="json"), self.robot.source)
        return _rebuilt, (*robot, self.names, self.responses, self.estimator.name, self.setting, self.weights)


def graybox_problem(
    robot: Robot,
    responses: Sequence[FrequencyResponse],
    names: Sequence[str] | None = None,
    estimator: str = "LLS",
    weights: Weights | str = "user",
) -> GrayBoxProblem:
    """Set up an identification.

    Args:
        robot: The robot with its nominal values.
        responses: Measured responses from all motor torques to all motors, one per position.
        names: Names of the unknown parameters; default: `unknown_parameters` of the robot file.
        estimator: "LLS", "LLSM" or "NLS".
        weights: Rule of the weights, or its kind: "user", "optimal" or "combined".

    Raises:
        InputError: Unknown names, responses that do not match the robot or each other, or weights that are all zero.
    """
    scale = parameter_scale(robot, robot.spec.unknown_parameters if names is None else names)
    chosen = estimator_named(estimator)
    setting = weights_named(weights) if isinstance(weights, str) else weights
    _check_responses(robot, responses)
    accelerations = tuple(response.as_quantity("acceleration") for response in responses)
    array = _weight_array(setting, accelerations, chosen)
    model = _frequency_model(robot, scale.names, accelerations, scale.nominal)
    return GrayBoxProblem(robot, scale, accelerations, chosen, setting, array, model)


def _rebuilt(
    data: dict[str, Any],
    source: str,
    names: tuple[str, ...],
    responses: tuple[FrequencyResponse, ...],
    estimator: str,
    setting: Weights,
    weights: FloatArray,
) -> GrayBoxProblem:
    """Build a problem from the tuple of `GrayBoxProblem.__reduce__`; compiled functions are created in each process."""
    robot = robot_from_data(data, source)
    scale = parameter_scale(robot, names)
    model = _frequency_model(robot, names, responses, scale.nominal)
    return GrayBoxProblem(robot, scale, responses, estimator_named(estimator), setting, weights, model)


def _frequency_model(
    robot: Robot, names: tuple[str, ...], responses: Sequence[FrequencyResponse], values: FloatArray
) -> FrequencyModel:
    motors = np.stack([response.motor_position for response in responses])
    positions = linearise_positions(robot, names, motors, values)
    return FrequencyModel(positions, responses[0].frequency, responses[0].sample_time, robot.delay)


def _weight_array(setting: Weights, responses: Sequence[FrequencyResponse], estimator: AbstractEstimator) -> FloatArray:
    array = setting.array(responses, estimator)
    if not np.any(array > 0):
        raise InputError(
            f"the {setting.kind} weights leave nothing to fit: every element of every line has weight 0; the responses "
            "are below the noise, or the band or the elements are too narrow"
        )
    return array


def _check_responses(robot: Robot, responses: Sequence[FrequencyResponse]) -> None:
    """Reject responses that do not match the robot or each other."""
    if not responses:
        raise InputError("no frequency response was given; give the response of at least one position")
    first = responses[0]
    for number, response in enumerate(responses):
        n_y, n_u = response.response.shape[1:]
        if (n_y, n_u) != (robot.n_motors, robot.n_motors):
            raise InputError(
                f"frequency response {number} has {n_y} outputs and {n_u} inputs, but robot {robot.name} has "
                f"{robot.n_motors} motors; give the response from all torques to all motors, or the robot measured"
            )
        if not np.all(np.isfinite(response.response)) or np.any(response.response == 0):
            raise InputError(
                f"frequency response {number} has elements that are zero, infinite or NaN, allowed are finite numbers; "
                "check the record it was estimated from"
            )
        if not np.all(np.isfinite(response.motor_position)):
            raise InputError(
                f"frequency response {number} does not state the motor positions at which it was measured "
                f"({np.round(response.motor_position, 4).tolist()}), allowed are finite numbers; estimate it from "
                "positions, or give its motor_position"
            )
        if response.sample_time != first.sample_time or not np.array_equal(response.frequency, first.frequency):
            raise InputError(
                f"frequency response {number} has other frequencies or another sample time than response 0; a fit "
                "needs the same lines at all positions"
            )
