"""Rounding of encoders is a gap of the model that does not know of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexros.effects import RobotWithEffects, parse_effect, place_effects
from flexros.gap.held_out.prediction_gap import AheadErrors
from flexros.gap.held_out.rounding import over_expected_floor, unknown_rounding
from flexros.gap.residuals.fit_data import FitData
from flexros.record.quantization import Quantization
from tests.gap.diagnosis_logs import MODEL, ROBOT, data_of

FOUND = Quantization(0, 1e-3)


def with_rounding() -> RobotWithEffects:
    return place_effects(ROBOT, [parse_effect("encoder_quantization@motor_1:step=0.001", "test")])


def rounded() -> FitData:
    """A log whose encoder has ten times the noise that the robot file states, most of it rounding."""
    data = data_of()
    noise = 10 * ROBOT.encoder_noise
    return replace(
        data,
        gain=replace(data.gain, noise=noise),
        measurement=replace(data.measurement, deviation=noise, quantizations=(FOUND,)),
    )


def test_rounding_that_the_model_has_is_known() -> None:
    measurement = rounded().measurement
    assert unknown_rounding(MODEL, measurement) == (FOUND,)
    assert unknown_rounding(with_rounding(), measurement) == ()


def test_errors_are_over_the_noise_of_the_robot_file_where_rounding_is_not_known() -> None:
    data, sigma = rounded(), ROBOT.encoder_noise
    errors = AheadErrors(np.ones((5, 1)), np.arange(5), np.sqrt(3.0**2 + 10.0**2) * sigma)
    np.testing.assert_allclose(over_expected_floor(errors, MODEL, data).floor, np.sqrt(3.0**2 + 1.0) * sigma)
    np.testing.assert_allclose(over_expected_floor(errors, MODEL, data).squares, 109.0 / 10.0)
    assert over_expected_floor(errors, with_rounding(), data) is errors
