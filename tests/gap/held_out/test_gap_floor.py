"""What the floor of a gap holds beside noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.effects import RobotWithEffects, parse_effect, place_effects
from flexros.gap.fit.candidate_fit import CandidateFit
from flexros.gap.held_out.errors_ahead import AheadErrors, errors_ahead
from flexros.gap.held_out.gap_floor import over_expected_floor, tolerance_floor, unknown_rounding
from flexros.gap.residuals.fit_data import FitData
from flexros.gap.residuals.prepare_fit_data import fit_data
from flexros.record.quantization import Quantization
from tests.gap.diagnosis_logs import MODEL, ROBOT, data_of, predictor_of, record_of

FOUND = Quantization(0, 1e-3)


@pytest.mark.slow
def test_the_floor_with_tolerance_is_the_gap_of_a_torque_that_is_off_by_it() -> None:
    nominal, log = CandidateFit(predictor_of(), np.zeros(0), 0.0), data_of()
    assert tolerance_floor(nominal, log) is None  # torques of a simulation are exact
    tolerated = replace(log, measurement=replace(log.measurement, signal_tolerance=0.05))
    record = record_of("torque_gain_error@motor_1:relative=0.05")
    off = errors_ahead(nominal, fit_data(record, MODEL, log.settings, torque_noise=log.torque_noise)).mean
    smaller = (record.torque.std() / log.record.torque.std()) ** 2  # for the same motion
    assert tolerance_floor(nominal, tolerated) == pytest.approx(off / smaller, rel=0.03)


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
