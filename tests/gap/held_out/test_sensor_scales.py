"""Sensors that read another multiple of what a model predicts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.gap.fit.candidate_fit import CandidateFit
from flexros.gap.held_out.sensor_scales import sensor_scale_words
from tests.gap.diagnosis_logs import predictor_of
from tests.gap.sensors.sensor_logs import sensed, sensed_data


@pytest.mark.parametrize(("scale", "told"), [(1.0, ""), (1.07, ""), (1.2, "1.2 times"), (0.8, "0.8 times")])
def test_a_sensor_of_another_scale_is_told(scale: float, told: str) -> None:
    """Of an arm one that read a fifth too much was within the tolerance of all else."""
    record = sensed(sensors=("joint torque",))
    record = replace(record, sensors=tuple(replace(one, values=scale * one.values) for one in record.sensors))
    words = sensor_scale_words(CandidateFit(predictor_of(), np.zeros(0), 0.0), sensed_data(record))
    assert len(words) == bool(told)
    assert all(f"joint torque of motor_1 reads {told}" in one for one in words)


def test_without_sensors_there_is_nothing_to_tell() -> None:
    assert sensor_scale_words(CandidateFit(predictor_of(), np.zeros(0), 0.0), sensed_data(sensed(sensors=()))) == ()
