"""Further sensors in predictions 0.1 s ahead."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.gap.fit.candidate_fit import CandidateFit
from flexros.gap.held_out.errors_ahead import AheadErrors, errors_ahead
from flexros.gap.held_out.gap_floor import over_expected_floor
from flexros.gap.held_out.gap_numbers import signal_gaps
from tests.gap.diagnosis_logs import MODEL, ROBOT, predictor_of
from tests.gap.sensors.sensor_logs import sensed, sensed_data

STIFFNESS = "stiffness_error@body_1.rz:relative=0.02"
SENSORS = ("link position", "joint torque", "tool acceleration")


def ahead(*effects: str, sensors: tuple[str, ...] = SENSORS, every: int = 1, seed: int = 1) -> AheadErrors:
    """Errors of the nominal model in such a log."""
    data = sensed_data(sensed(*effects, sensors=sensors, every=every, seed=seed))
    return errors_ahead(CandidateFit(predictor_of(), np.zeros(0), 0.0), data)


@pytest.mark.parametrize("every", [1, 7])
def test_without_a_gap_every_signal_is_at_its_floor(every: int) -> None:
    errors = ahead(every=every)
    assert errors.squares.shape == (len(errors.starts), 1 + len(SENSORS))
    assert len(errors.sensors) == len(SENSORS)
    np.testing.assert_allclose(errors.squares.mean(axis=0), 1.0, atol=0.3)


def test_the_gap_is_the_mean_over_all_signals() -> None:
    errors = ahead(STIFFNESS)
    by_signal = errors.squares.mean(axis=0)
    assert errors.mean == pytest.approx(by_signal.mean())
    assert by_signal[1] > 50


def test_signals_are_named_with_their_units() -> None:
    errors = ahead(STIFFNESS)
    gaps = signal_gaps(ROBOT, errors)
    assert [gap.signal.partition(",")[0] for gap in gaps] == [
        "motor_1 position",
        "link position of motor_1",
        "joint torque of motor_1",
        "tool acceleration along x",
    ]
    assert [gap.unit[-3:] for gap in gaps] == ["rad", "rad", "mNm", "/s2"]
    assert gaps[2].floor == pytest.approx(50, rel=0.05)


def test_another_floor_of_the_encoders_leaves_the_sensors() -> None:
    data = sensed_data(sensed(sensors=("link position",)))
    errors = errors_ahead(CandidateFit(predictor_of(), np.zeros(0), 0.0), data)
    np.testing.assert_array_equal(over_expected_floor(errors, MODEL, data).floor, errors.floor)
