"""Where the gap shows in further sensors."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.gap.fit.candidate_fit import CandidateFit
from flexros.gap.held_out.predictions import prediction_of, sensor_errors
from flexros.gap.schema import Excess
from flexros.gap.where.find import where
from tests.gap.diagnosis_logs import ROBOT, predictor_of
from tests.gap.sensors.sensor_logs import sensed, sensed_data

pytestmark = pytest.mark.slow


def located(*effects: str, sensors: tuple[str, ...], every: int = 1) -> tuple[Excess, ...]:
    data = sensed_data(sensed(*effects, sensors=sensors, every=every))
    fit = CandidateFit(predictor_of(), np.zeros(0), 0.0)
    found = where(prediction_of(fit, data), data.record, ROBOT, 1, sensors=sensor_errors(fit, data))
    return tuple(one for one in found.mapped if one.signal in sensors)


def test_a_gap_shows_in_the_sensor_at_its_joint() -> None:
    found = located("hysteresis@motor_1:level=0.5,angle=0.002", sensors=("joint torque",))
    assert found
    assert {(one.signal, one.joint) for one in found} == {("joint torque", "motor_1")}
    assert min(one.p_value for one in found) < 0.01


def test_noise_of_a_slow_sensor_is_no_gap() -> None:
    found = located(sensors=("link position", "tool acceleration"), every=7)
    assert {one.joint for one in found} == {"motor_1", "tool"}
    assert min(one.p_value for one in found) > 0.01


def test_logs_without_sensors_have_no_such_locations() -> None:
    data = sensed_data(sensed())
    fit = CandidateFit(predictor_of(), np.zeros(0), 0.0)
    found = where(prediction_of(fit, data), data.record, ROBOT, 1)
    assert all(one.signal != "link position" for one in found.mapped)
