"""The gap of predictions 0.1 s ahead: 1 without a gap, and the share that a repair closes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.effects import RobotWithEffects, parse_effect, place_effects
from flexros.gap.fit.least_squares import CandidateFit
from flexros.gap.held_out.closed_share import closed_fraction, share_between
from flexros.gap.held_out.errors_ahead import AheadErrors, errors_ahead
from flexros.gap.held_out.gap_floor import over_expected_floor, tolerance_floor, unknown_rounding
from flexros.gap.held_out.gap_numbers import signal_gaps
from flexros.gap.residuals.fit_data import FitData, fit_data
from flexros.record.quantization import Quantization
from flexros.robot import load_robot
from tests.gap.diagnosis_logs import MODEL, ROBOT, candidates_of, data_of, encoded, predictor_of, record_of

FRICTION = "coulomb_friction@motor_1:level=0.05"
SPACING = 50  # samples
FOUND = Quantization(0, 1e-3)


def ahead(effects: tuple[str, ...] = (), level: float | None = None, seed: int = 1) -> AheadErrors:
    """Errors of a log with effects, under the nominal model or with Coulomb friction."""
    hypothesis = () if level is None else (candidates_of()["coulomb_friction@motor_1"],)
    predictor = predictor_of(*hypothesis)
    theta = np.array([] if level is None else encoded(hypothesis[0], level=level))
    return errors_ahead(CandidateFit(predictor, theta, 0.0), data_of(*effects, seed=seed))


def synthetic(level: float, seed: int = 0, windows: int = 2000) -> AheadErrors:
    """White errors of a mean square."""
    squares = level * np.random.default_rng(seed).normal(size=(windows, 1)) ** 2
    return AheadErrors(squares, SPACING * np.arange(windows), np.array([1e-4]))


@pytest.mark.slow
def test_without_gap_it_is_one() -> None:
    means = [ahead(seed=seed).mean for seed in (1, 2, 3)]
    # some 500 windows of 0.1 s in each log that overlap, four to an independent one
    assert np.mean(means) == pytest.approx(1.0, abs=4 * np.sqrt(2 / (3 * 500 / 4)))


@pytest.mark.slow
def test_a_gap_shows_and_the_true_model_closes_it() -> None:
    before, after = ahead((FRICTION,)), ahead((FRICTION,), level=0.05)
    assert before.mean > 20
    assert after.mean == pytest.approx(1.0, abs=0.35)
    share = closed_fraction(before, after, ROBOT.sample_time)
    assert share is not None
    assert share.value == pytest.approx(1.0, abs=0.02)
    assert share.interval[0] <= share.value <= share.interval[1]


@pytest.mark.slow
def test_the_floor_with_tolerance_is_the_gap_of_a_torque_that_is_off_by_it() -> None:
    nominal, log = CandidateFit(predictor_of(), np.zeros(0), 0.0), data_of()
    assert tolerance_floor(nominal, log) is None  # torques of a simulation are exact
    tolerated = replace(log, measurement=replace(log.measurement, signal_tolerance=0.05))
    record = record_of("torque_gain_error@motor_1:relative=0.05")
    off = errors_ahead(nominal, fit_data(record, MODEL, log.settings, level=log.level)).mean
    smaller = (record.torque.std() / log.record.torque.std()) ** 2  # for the same motion
    assert tolerance_floor(nominal, tolerated) == pytest.approx(off / smaller, rel=0.03)


def test_what_opens_between_two_repairs_is_a_share_of_the_whole_gap() -> None:
    before, more, less = (synthetic(level, seed) for seed, level in enumerate((11.0, 6.0, 3.5)))
    share = share_between(before, more, less, ROBOT.sample_time)
    assert share is not None
    assert share.value == pytest.approx(0.25, abs=0.06)
    assert share.interval[0] < 0.25 < share.interval[1]


def test_windows_lie_within_the_log_and_avoid_missing_samples() -> None:
    data = data_of()
    valid = data.record.valid.copy()
    valid[10_000:10_100] = False
    holed = replace(data, record=replace(data.record, valid=valid))
    found = errors_ahead(CandidateFit(predictor_of(), np.zeros(0), 0.0), holed)
    horizon = round(0.1 / ROBOT.sample_time)
    assert np.all(found.starts + horizon < data.record.n_samples)
    assert not np.any((found.starts < 10_100) & (found.starts + horizon >= 10_000))
    assert len(found.starts) == len(found.squares)


def test_closed_share_is_that_of_the_excess_over_the_floor() -> None:
    share = closed_fraction(synthetic(11.0, 0), synthetic(6.0, 1), ROBOT.sample_time)
    assert share is not None
    assert share.value == pytest.approx(0.5, abs=0.06)
    assert share.interval[0] < 0.5 < share.interval[1]
    assert share.interval[1] - share.interval[0] < 0.2


def test_a_repair_that_does_nothing_closes_nothing() -> None:
    same = synthetic(11.0)
    share = closed_fraction(same, same, ROBOT.sample_time)
    assert share is not None
    assert share.value == 0.0
    assert share.interval == (0.0, 0.0)


def test_errors_that_do_not_exceed_noise_have_no_share() -> None:
    assert closed_fraction(synthetic(1.0), synthetic(1.0, 1), ROBOT.sample_time) is None


def test_errors_over_another_floor() -> None:
    found = synthetic(4.0).over(np.array([2e-4]))
    assert found.mean == pytest.approx(synthetic(4.0).mean / 4)
    assert found.floor[0] == 2e-4


def errors(*ratios: float, floor: float) -> AheadErrors:
    """Errors whose rms is a multiple of the floor, by motor."""
    squares = np.repeat(np.square([ratios]), 7, axis=0)
    return AheadErrors(squares, 50 * np.arange(7), np.full(len(ratios), floor))


def test_every_motor_has_its_rms_before_and_after() -> None:
    first, second = signal_gaps(load_robot("e12"), errors(10, 3, floor=1e-4), errors(1.5, 1, floor=1e-4))
    assert (first.signal, first.unit) == ("motor_1 position, 0.1 s ahead", "mrad")
    assert (first.before, first.after, first.floor, first.rival) == pytest.approx((1.0, 0.15, 0.1, None))
    assert second.before == pytest.approx(0.3)


def test_small_errors_and_sliding_motors_have_units_of_their_own() -> None:
    (gap,) = signal_gaps(load_robot("emps"), errors(4, floor=1e-6), rival=errors(2, floor=1e-6))
    assert (gap.unit, gap.before, gap.rival) == ("µm", pytest.approx(4.0), pytest.approx(2.0))


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
