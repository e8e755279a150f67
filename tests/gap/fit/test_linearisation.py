"""Linearisation: derivatives are those of the weighted errors, and values that jump have none."""

from __future__ import annotations

from typing import cast

import numpy as np
import pytest

from flexros.arrays import FloatArray
from flexros.effects import place_effects
from flexros.gap.candidates.tolerance import Tolerance, tolerance_of
from flexros.gap.fit.candidate_fit import CandidateFit
from flexros.gap.fit.linearisation import JUMP, carried_on, linearise, linearised, with_smooth_slopes, without_jumps
from flexros.gap.prediction.compiled_plant import LANES
from flexros.gap.prediction.predictor import Predictor
from flexros.gap.residuals.fit_data import FitData
from flexros.gap.residuals.prepare_fit_data import fit_data
from flexros.gap.settings import DiagnosisSettings
from flexros.record.record import Record
from flexros.robot import load_robot
from tests.gap.diagnosis_logs import candidates_of, data_of, encoded, predictor_of

pytestmark = pytest.mark.slow


class Lines:
    """Predictor and log of errors that are linear in fifteen parameters; counts the predictions."""

    n_effect, bounds, tolerance = 15, (np.full(15, -1.0), np.full(15, 1.0)), Tolerance()
    jumps = False
    fineness = np.ones(15)

    misfit, settings = 1.0, DiagnosisSettings(threads=1)

    def __init__(self) -> None:
        self.passes = 0

    def residuals(self, _: object, thetas: FloatArray) -> FloatArray:
        assert thetas.shape[1] <= LANES
        self.passes += 1
        slopes = np.random.default_rng(1).normal(size=(50, 15))
        return np.asarray(1.0 + slopes @ thetas)


def test_every_lane_of_a_prediction_but_one_makes_a_derivative() -> None:
    lines = Lines()
    found = linearise(cast("Predictor", lines), cast("FitData", lines), np.zeros(15))
    np.testing.assert_allclose(found.slopes, np.random.default_rng(1).normal(size=(50, 15)), atol=1e-9)
    np.testing.assert_array_equal(found.residual, np.ones(50))
    assert lines.passes == 2  # of eight lanes each


def test_slopes_are_derivatives_of_the_weighted_errors() -> None:
    candidate = candidates_of()["viscous_friction@motor_1"]
    predictor, theta = predictor_of(candidate), np.array(encoded(candidate, coefficient=3e-3, asymmetry=0.3))
    line = linearise(predictor, data_of(), theta)
    step = 1e-4 * np.eye(2)
    for k in range(2):
        ends = data_of().residuals(predictor, np.stack([theta + step[k], theta - step[k]], axis=-1))
        difference = (ends[:, 0] - ends[:, 1]) / 2e-4
        assert np.linalg.norm(line.slopes[:, k] - difference) < 0.01 * np.linalg.norm(difference)
    np.testing.assert_allclose(line.gradient, line.slopes.T @ line.residual)
    np.testing.assert_allclose(line.information, line.slopes.T @ line.slopes)


def test_derivatives_after_a_step_are_those_before_it_but_along_it_where_they_make_what_it_changed() -> None:
    lines = Lines()
    predictor, data = cast("Predictor", lines), cast("FitData", lines)
    step, before = np.linspace(-0.2, 0.1, 15), linearise(predictor, data, np.zeros(15))
    slopes, residual = before.slopes.copy(), before.residual + before.slopes @ step + 3.0
    carried = carried_on(before, predictor, data, step, step, residual)
    np.testing.assert_allclose(carried.slopes @ step, slopes @ step + 3.0)
    across = np.random.default_rng(0).normal(size=15)
    weighted = np.diag(before.information) * step
    across -= step * (weighted @ across) / (weighted @ step)
    np.testing.assert_allclose(carried.slopes @ across, slopes @ across)
    assert carried.chi2 == pytest.approx(residual @ residual)
    np.testing.assert_allclose(carried.gradient, carried.slopes.T @ residual)


def test_a_step_lowers_the_sum_of_squares_of_linear_errors_as_it_promises() -> None:
    lines = Lines()
    predictor, data, step = cast("Predictor", lines), cast("FitData", lines), np.linspace(-0.02, 0.01, 15)
    before, after = (linearise(predictor, data, theta) for theta in (np.zeros(15), step))
    assert before.fall_by(step) == pytest.approx(before.chi2 - after.chi2)


def test_derivatives_by_errors_that_are_known_are_the_same() -> None:
    candidate = candidates_of()["coulomb_friction@motor_1"]
    predictor, theta = predictor_of(candidate), np.array(encoded(candidate, level=0.05))
    anew = linearise(predictor, data_of(), theta)
    known = linearise(predictor, data_of(), theta, residual=anew.residual)
    np.testing.assert_allclose(known.slopes, anew.slopes, atol=1e-9 * np.abs(anew.slopes).max())
    assert known.chi2 == anew.chi2


def test_a_fit_is_linearised_once() -> None:
    candidate = candidates_of()["coulomb_friction@motor_1"]
    found = CandidateFit(predictor_of(candidate), np.array(encoded(candidate, level=0.05)), 0.0)
    assert linearised(found, data_of()) is linearised(found, data_of())


def test_derivatives_to_tolerated_numbers_by_few_long_steps_are_those_by_many() -> None:
    robot, T, n = load_robot("elbow"), 2e-3, 1000
    time = T * np.arange(n)[:, None] + np.arange(robot.n_motors)
    noise = robot.encoder_noise * np.random.default_rng(1).normal(size=time.shape)
    record = Record("log", T, 0.02 * np.sin(2 * np.pi * time) + noise, 5 * np.sin(3 * time), np.ones(n, dtype=bool))
    model, tolerance = place_effects(robot, ()), tolerance_of(robot, {"stiffness": 0.01, "inertia": 0.01})
    data = fit_data(record, model, DiagnosisSettings())
    predictor = Predictor(model, (), tolerance, T)
    assert tolerance.n_free >= LANES
    assert predictor.coarse is not None
    few = linearise(predictor, data, np.zeros(tolerance.n_free)).slopes
    vars(predictor)["coarse"] = None
    many = linearise(predictor, data, np.zeros(tolerance.n_free)).slopes
    assert np.any(few != many)
    assert np.all(np.linalg.norm(few - many, axis=0) < 0.01 * np.linalg.norm(many, axis=0))


def test_a_few_values_that_jump_are_no_derivatives() -> None:
    random = np.random.default_rng(0)
    smooth = random.normal(size=(4000, 2))
    jumps = smooth.copy()
    jumps[[5, 700, 3100], 1] = [300.0, -500.0, 80.0]
    found = without_jumps(jumps)
    assert np.array_equal(found[:, 0], smooth[:, 0])
    assert np.flatnonzero(found[:, 1] != smooth[:, 1]).tolist() == [5, 700, 3100]
    assert not found[[5, 700, 3100], 1].any()
    assert np.abs(found).max() < JUMP


def test_derivatives_that_are_medians_of_several_steps_are_those_of_smooth_predictions() -> None:
    every = candidates_of()
    predictor = predictor_of(every["coulomb_friction@motor_1"])
    data, theta = data_of(), np.zeros(predictor.n_fitted)
    theta[0] = encoded(every["coulomb_friction@motor_1"], level=0.05)[0]
    usual = linearise(predictor, data, theta)
    medians = with_smooth_slopes(usual, predictor, data, theta)
    scale = np.abs(usual.slopes).max(axis=0)
    assert np.abs(medians.slopes - usual.slopes).max() < 0.02 * scale.max()
    assert medians.information == pytest.approx(usual.information, rel=0.05, abs=1e-3 * usual.information.max())


def test_what_shows_in_a_part_of_the_log_is_no_jump() -> None:
    slopes = np.zeros((4000, 1))
    slopes[1000:1200, 0] = np.linspace(1.0, 2.0, 200)
    assert np.array_equal(without_jumps(slopes), slopes)


def test_predictions_jump_with_contacts_alone() -> None:
    every = candidates_of()
    assert predictor_of(every["backlash@motor_1"]).jumps
    assert not predictor_of(every["coulomb_friction@motor_1"]).jumps
