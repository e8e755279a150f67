"""Locations of a gap."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

from flexros.gap.prediction.predicted_log import PredictedLog
from flexros.gap.settings import WhereSettings
from flexros.gap.where.find import FEWEST, where
from flexros.record.record import ToolRecord
from tests.oracles.linear_gap import LinearLog

pytestmark = pytest.mark.slow

FEW = WhereSettings(realisations=60)


def test_friction_shows_at_the_right_joint(elbow_with_friction: LinearLog) -> None:
    log = elbow_with_friction
    found = where(log.prediction, log.record, log.robot, 1, spectrum=log.error_spectrum, settings=FEW)
    assert found.p_value <= 1 / 61
    assert found.locations[0].joint == "motor_2"
    assert found.locations[0].p_value <= 1 / 61
    assert found.excess[1] > 50 * found.excess[0]


def test_friction_sets_in_at_reversals(elbow_with_friction: LinearLog) -> None:
    log = elbow_with_friction
    found = where(log.prediction, log.record, log.robot, 1, spectrum=log.error_spectrum, settings=FEW)
    innovations = [location for location in found.locations if location.signal == "sudden position change"]
    assert innovations[0].regime == "reversal"
    assert innovations[0].joint == "motor_2"
    assert innovations[0].share > 0.5


def test_ripple_shows_at_its_order(axis_with_ripple: LinearLog) -> None:
    log = axis_with_ripple
    found = where(log.prediction, log.record, log.robot, 1, spectrum=log.error_spectrum, settings=FEW)
    orders = [location for location in found.locations if location.regime.startswith("motor angle order")]
    assert float(orders[0].regime.split()[-1]) == pytest.approx(6.0, abs=0.1)
    assert orders[0].p_value <= 1 / 61


def test_nothing_is_reported_without_a_gap(elbow_without_gap: LinearLog) -> None:
    log = elbow_without_gap
    found = where(log.prediction, log.record, log.robot, 1, spectrum=log.error_spectrum, settings=FEW)
    assert found.p_value > 0.05
    assert found.locations == ()
    assert np.all(np.abs(found.excess) < 0.1)


def test_level_of_the_noise_makes_no_gap(elbow_without_gap: LinearLog) -> None:
    log = elbow_without_gap
    louder = PredictedLog(3 * log.prediction.innovations, log.prediction.sd, log.prediction.states)
    assert where(louder, log.record, log.robot, 1, spectrum=log.error_spectrum, settings=FEW).locations == ()
    known = WhereSettings(realisations=60, floor="predicted")
    assert where(louder, log.record, log.robot, 1, spectrum=log.error_spectrum, settings=known).locations != ()


def test_false_alarms_stay_within_their_size(elbow_without_gap: LinearLog) -> None:
    """Of 15 logs without gap more than 3 alarms at one in 31 come with a probability of 0.2 %."""
    log = elbow_without_gap
    record = log.record.part(4000, 7000)
    states = log.prediction.states
    assert states is not None
    random = np.random.default_rng(5)
    short = WhereSettings(realisations=30, orders=20)
    alarms = 0
    for seed in range(15):
        noise = PredictedLog(random.standard_normal((3000, 2)), np.ones(2), states[4000:7000])
        alarms += where(noise, record, log.robot, seed, settings=short).p_value <= 0.05
    assert alarms <= 3


def test_missing_samples_make_no_gap(elbow_without_gap: LinearLog) -> None:
    log = elbow_without_gap
    valid = np.ones(log.record.n_samples, dtype=bool)
    valid[2000:2600] = False
    errors = np.where(valid[:, None], log.prediction.innovations, 0.0)
    prediction = PredictedLog(errors, log.prediction.sd, log.prediction.states)
    found = where(prediction, replace(log.record, valid=valid), log.robot, 1, settings=FEW)
    assert found.locations == ()


def test_tool_errors_are_a_signal_of_their_own(elbow_without_gap: LinearLog) -> None:
    log = elbow_without_gap
    time = np.arange(2800) * 2e-3
    random = np.random.default_rng(1)
    error = 2e-5 * random.standard_normal((2800, 3))
    record = replace(log.record, tool=ToolRecord(time, np.zeros((2800, 3))))
    spectrum = log.error_spectrum
    still = where(log.prediction, record, log.robot, 1, tool_error=error, spectrum=spectrum, settings=FEW)
    assert still.locations == ()
    assert any(location.signal == "tool" for location in still.mapped)
    error[:, 2] += 4e-5 * np.sin(2 * np.pi * 12 * time)
    moving = where(log.prediction, record, log.robot, 1, tool_error=error, spectrum=spectrum, settings=FEW)
    assert moving.locations[0].signal == "tool"
    assert moving.locations[0].band_hz[0] < 12 < moving.locations[0].band_hz[1]


def test_maps_cover_bands_and_regimes(elbow_without_gap: LinearLog) -> None:
    log = elbow_without_gap
    mapped = where(log.prediction, log.record, log.robot, 1, settings=FEW).mapped
    for joint in log.robot.joint_names:
        of_joint = [location for location in mapped if location.joint == joint and location.signal == "position"]
        bands = sorted(location.band_hz for location in of_joint if location.regime == "all")
        assert bands[0][0] == 0
        assert bands[-1][1] == 0.5 / log.record.sample_time
        assert all(low[1] == high[0] for low, high in itertools.pairwise(bands))
        assert {"reversal", "low speed", "high speed"} <= {location.regime for location in of_joint}


@pytest.mark.parametrize("samples", [150, 700])
def test_gaps_of_short_slow_logs_are_located_without_states(samples: int, elbow_without_gap: LinearLog) -> None:
    log = elbow_without_gap
    record = replace(log.record.part(0, samples), sample_time=0.01)
    noise = np.random.default_rng(4).standard_normal((samples, 2))
    assert where(PredictedLog(noise, np.ones(2)), record, log.robot, 1, settings=FEW).locations == ()
    noise[samples // 2 :, 1] += 5.0
    assert where(PredictedLog(noise, np.ones(2)), record, log.robot, 1, settings=FEW).locations[0].joint == "motor_2"


def test_diverged_predictions_are_left_out(elbow_without_gap: LinearLog) -> None:
    log = elbow_without_gap
    errors = log.prediction.innovations.copy()
    errors[9000:] = np.nan
    found = where(PredictedLog(errors, log.prediction.sd), log.record, log.robot, 1, settings=FEW)
    assert np.all(np.isfinite(found.excess))
    errors[:] = np.nan
    assert where(PredictedLog(errors, log.prediction.sd), log.record, log.robot, 1, settings=FEW).mapped == ()


def test_where_there_is_no_time_a_few_simulated_logs_suffice(elbow_with_friction: LinearLog) -> None:
    log, asked = elbow_with_friction, [0]

    def stop() -> bool:
        asked[0] += 1
        return True

    found = where(log.prediction, log.record, log.robot, 1, spectrum=log.error_spectrum, settings=FEW, stop=stop)
    assert asked == [1]
    assert found.locations[0].joint == "motor_2"
    assert found.p_value == pytest.approx(1 / (FEWEST + 1))
