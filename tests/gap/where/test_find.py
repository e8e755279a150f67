"""Where a gap shows."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

from flexros.gap.prediction.predicted_log import PredictedLog
from flexros.gap.where.find import where
from flexros.gap.where.floor import of_predictor
from flexros.gap.where.settings import WhereSettings
from flexros.record.record import ToolRecord
from tests.oracles.linear_gap import LinearLog

FEW = WhereSettings(realisations=60)


def test_friction_shows_at_the_right_joint(elbow_with_friction: LinearLog) -> None:
    log = elbow_with_friction
    found = where(log.prediction, log.record, log.robot, 1, spectrum=of_predictor(log.observer), settings=FEW)
    assert found.p_value <= 1 / 61
    assert found.places[0].joint == "motor_2"
    assert found.places[0].p_value <= 1 / 61
    assert found.excess[1] > 50 * found.excess[0]


def test_friction_sets_in_at_reversals(elbow_with_friction: LinearLog) -> None:
    log = elbow_with_friction
    found = where(log.prediction, log.record, log.robot, 1, spectrum=of_predictor(log.observer), settings=FEW)
    sudden = [place for place in found.places if place.signal == "sudden position change"]
    assert sudden[0].regime == "reversal"
    assert sudden[0].joint == "motor_2"
    assert sudden[0].share > 0.5


def test_ripple_shows_at_its_order(axis_with_ripple: LinearLog) -> None:
    log = axis_with_ripple
    found = where(log.prediction, log.record, log.robot, 1, spectrum=of_predictor(log.observer), settings=FEW)
    told = [place for place in found.places if place.regime.startswith("motor angle order")]
    assert float(told[0].regime.split()[-1]) == pytest.approx(6.0, abs=0.1)
    assert told[0].p_value <= 1 / 61


def test_nothing_is_told_without_a_gap(elbow_without_gap: LinearLog) -> None:
    log = elbow_without_gap
    found = where(log.prediction, log.record, log.robot, 1, spectrum=of_predictor(log.observer), settings=FEW)
    assert found.p_value > 0.05
    assert found.places == ()
    assert np.all(np.abs(found.excess) < 0.1)


def test_level_of_the_noise_makes_no_gap(elbow_without_gap: LinearLog) -> None:
    log = elbow_without_gap
    louder = PredictedLog(3 * log.prediction.innovations, log.prediction.sd, log.prediction.states)
    assert where(louder, log.record, log.robot, 1, spectrum=of_predictor(log.observer), settings=FEW).places == ()
    known = WhereSettings(realisations=60, floor="predicted")
    assert where(louder, log.record, log.robot, 1, spectrum=of_predictor(log.observer), settings=known).places != ()


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
    assert found.places == ()


def test_projected_errors_are_looked_at_instead(elbow_with_friction: LinearLog, elbow_without_gap: LinearLog) -> None:
    log = elbow_with_friction
    free = elbow_without_gap.prediction.innovations
    spectrum = of_predictor(log.observer)
    found = where(log.prediction, log.record, log.robot, 1, projected=free, spectrum=spectrum, settings=FEW)
    assert found.places == ()


def test_tool_errors_are_a_signal_of_their_own(elbow_without_gap: LinearLog) -> None:
    log = elbow_without_gap
    time = np.arange(2800) * 2e-3
    random = np.random.default_rng(1)
    error = 2e-5 * random.standard_normal((2800, 3))
    record = replace(log.record, tool=ToolRecord(time, np.zeros((2800, 3))))
    spectrum = of_predictor(log.observer)
    still = where(log.prediction, record, log.robot, 1, tool_error=error, spectrum=spectrum, settings=FEW)
    assert still.places == ()
    assert any(place.signal == "tool" for place in still.looked)
    error[:, 2] += 4e-5 * np.sin(2 * np.pi * 12 * time)
    moving = where(log.prediction, record, log.robot, 1, tool_error=error, spectrum=spectrum, settings=FEW)
    assert moving.places[0].signal == "tool"
    assert moving.places[0].band_hz[0] < 12 < moving.places[0].band_hz[1]


def test_places_looked_at_cover_bands_and_regimes(elbow_without_gap: LinearLog) -> None:
    log = elbow_without_gap
    looked = where(log.prediction, log.record, log.robot, 1, settings=FEW).looked
    for joint in log.robot.joint_names:
        mine = [place for place in looked if place.joint == joint and place.signal == "position"]
        bands = sorted(place.band_hz for place in mine if place.regime == "all")
        assert bands[0][0] == 0
        assert bands[-1][1] == 0.5 / log.record.sample_time
        assert all(low[1] == high[0] for low, high in itertools.pairwise(bands))
        assert {"reversal", "low speed", "high speed"} <= {place.regime for place in mine}


@pytest.mark.parametrize("samples", [150, 700])
def test_short_slow_logs_are_looked_at_without_states(samples: int, elbow_without_gap: LinearLog) -> None:
    log = elbow_without_gap
    record = replace(log.record.part(0, samples), sample_time=0.01)
    noise = np.random.default_rng(4).standard_normal((samples, 2))
    assert where(PredictedLog(noise, np.ones(2)), record, log.robot, 1, settings=FEW).places == ()
    noise[samples // 2 :, 1] += 5.0
    assert where(PredictedLog(noise, np.ones(2)), record, log.robot, 1, settings=FEW).places[0].joint == "motor_2"


def test_diverged_predictions_are_left_out(elbow_without_gap: LinearLog) -> None:
    log = elbow_without_gap
    errors = log.prediction.innovations.copy()
    errors[9000:] = np.nan
    found = where(PredictedLog(errors, log.prediction.sd), log.record, log.robot, 1, settings=FEW)
    assert np.all(np.isfinite(found.excess))
    errors[:] = np.nan
    assert where(PredictedLog(errors, log.prediction.sd), log.record, log.robot, 1, settings=FEW).looked == ()
