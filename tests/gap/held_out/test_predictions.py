"""Predictions that a report keeps."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexros.effects import parse_effect
from flexros.gap.fit.candidate_fit import CandidateFit
from flexros.gap.fit.estimates import placed_effects
from flexros.gap.held_out.predictions import prediction_of, sensor_errors, signature_evidence, tool_errors
from flexros.gap.result import Explanation
from tests.gap.diagnosis_logs import MODEL, ROBOT, candidates_of, data_of, encoded, predictor_of

SOFT = "stiffness_error@body_2.rz:relative=-0.05"


def explanation(relative: float | None) -> Explanation:
    hypothesis = () if relative is None else (candidates_of()["stiffness_error@body_2.rz"],)
    theta = np.array([] if relative is None else encoded(hypothesis[0], relative=relative))
    one = CandidateFit(predictor_of(*hypothesis), theta, 0.0)
    return Explanation("test", prediction_of(one, data_of(SOFT)), None, placed_effects(one))


@pytest.mark.slow
def test_innovations_are_the_prediction_errors_and_counted_from_where_the_start_decayed() -> None:
    found, data = explanation(-0.05).fit, data_of(SOFT)
    assert found.innovations.shape == data.record.position.shape
    assert found.states is not None
    assert found.states.shape == (data.record.n_samples, 2 * ROBOT.n_coordinates)
    assert found.first == data.gain.settling
    scaled = found.innovations[found.first :] / found.sd
    assert np.mean(scaled**2) == pytest.approx(1.0, abs=0.05)


def test_states_are_corrected_ones() -> None:
    """The motor position is nearer to the measured one than noise."""
    found, data = explanation(None).fit, data_of(SOFT)
    assert found.states is not None
    motor = found.states[:, list(ROBOT.motor_rows)]
    assert np.std(motor - data.record.position) < 3 * np.std(found.innovations)


def test_pictures_see_the_log_before_and_after_the_repair() -> None:
    before, after = explanation(None), explanation(-0.05)
    data, nothing = data_of(SOFT), CandidateFit(predictor_of(), np.zeros(0), 0.0)
    found = signature_evidence(MODEL, data, nothing, before, after)
    assert (found.before, found.after) == (before.fit, after.fit)
    assert found.repaired is not None
    nominal = ROBOT.parameters["body_2.rz.stiffness"].value
    assert found.repaired.parameters["body_2.rz.stiffness"].value == pytest.approx(0.95 * nominal)
    assert found.tool_error is None
    assert signature_evidence(MODEL, data, nothing, before, None).repaired is None


def test_pictures_of_the_repaired_robot_have_its_viscous_friction() -> None:
    """It is a law beside the robot: without it the frequency response of both robots was one curve."""
    friction = (parse_effect("viscous_friction@motor_1:coefficient=3", "test"),)
    data, nothing = data_of(SOFT), CandidateFit(predictor_of(), np.zeros(0), 0.0)
    before = explanation(None)
    found = signature_evidence(MODEL, data, nothing, before, replace(before, effects=friction))
    assert found.repaired is not None
    name = "motor_1.viscous_friction"
    assert found.repaired.parameters[name].value == pytest.approx(ROBOT.parameters[name].value + 3)
    assert found.robot.parameters[name].value == ROBOT.parameters[name].value


@pytest.mark.slow
def test_error_of_the_tool_is_what_the_model_lacks_beyond_noise_and_the_frame_of_the_tracker() -> None:
    """A soft spring shows; without it the error is the noise of the tracker."""
    nothing = CandidateFit(predictor_of(), np.zeros(0), 0.0)
    still, soft = (tool_errors(nothing, data_of(*effects, tool=True)) for effects in ((), (SOFT,)))
    assert still is not None
    assert soft is not None
    record, error = still
    assert error.shape == record.position.shape
    sizes = [float(np.sqrt(np.mean(np.sum(one**2, axis=1)))) for _, one in (still, soft)]
    assert sizes[0] < 2.5 * ROBOT.tool_noise
    assert sizes[1] > sizes[0]


def test_errors_of_sensors_stand_before_those_of_torques() -> None:
    positions, sensors, torques = np.zeros(6), np.full(4, 2.0), np.full(9, 7.0)
    fit: Any = SimpleNamespace(residual=lambda data: np.concatenate([positions, sensors, torques]))
    channel = SimpleNamespace(measured=np.zeros(4), sensor="sensor", used=None)
    data: Any = SimpleNamespace(spread=np.ones((3, 2)), tool=None, sensors=SimpleNamespace(size=4, channels=[channel]))
    (found,) = sensor_errors(fit, data)
    np.testing.assert_array_equal(found.errors, sensors)
