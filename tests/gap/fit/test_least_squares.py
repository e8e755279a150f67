"""Fits: known parameters come back with honest deviations, from bad starts, within their bounds."""

from __future__ import annotations

from dataclasses import replace
from typing import cast

import numpy as np
import pytest

from flexros.arrays import FloatArray
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.fit.candidate_fit import CandidateFit
from flexros.gap.fit.initial_values import initial_values
from flexros.gap.fit.least_squares import fit
from flexros.gap.fit.sum_of_squares import chi2_of
from flexros.gap.prediction.predictor import Predictor
from flexros.gap.residuals.fit_data import FitData
from flexros.gap.settings import DiagnosisSettings
from tests.gap.diagnosis_logs import WHOLE, candidates_of, data_of, encoded, predictor_of

pytestmark = pytest.mark.slow

N = 12000
TRUTHS = {
    "coulomb_friction@motor_1": {"level": 0.05},
    "stiffness_error@body_2.rz": {"relative": 0.04},
    "viscous_friction@motor_1": {"coefficient": 3e-3, "asymmetry": 0.3},
    "backlash@motor_1": {"gap": 1e-3},
}


def made(predictor: Predictor, theta: FloatArray, seed: int) -> FitData:
    """Log that a model would make under the torques of a real one, with white noise of the encoder."""
    data = data_of(length=WHOLE)
    record = data.record.part(0, N)
    blind = replace(data.gain, gain=np.zeros_like(data.gain.gain))
    errors = predictor.predict(theta[:, None], record, blind, data.initial_state).innovation[:, :, 0]
    noise = data.gain.noise * np.random.default_rng(seed).normal(size=record.position.shape)
    return replace(data, record=replace(record, position=record.position - errors + noise), spread=data.spread[:N])


def deviations(found: CandidateFit) -> FloatArray:
    return np.asarray(np.sqrt(np.diag(np.linalg.inv(found.information))))


@pytest.mark.parametrize(("name", "values"), TRUTHS.items())
def test_known_numbers_come_back(name: str, values: dict[str, float]) -> None:
    candidate = candidates_of()[name]
    predictor, truth = predictor_of(candidate), np.array(encoded(candidate, **values))
    data = made(predictor, truth, 0)
    starts = initial_values(predictor)
    start = starts[:, np.argmin(chi2_of(predictor, data, starts))]
    found = fit(predictor, data, start, 20)
    assert found.converged
    assert found.chi2 / data.n_values == pytest.approx(1.0, abs=5 * np.sqrt(2 / data.n_values))
    assert np.all(np.abs(found.theta - truth) < 5 * deviations(found))
    np.testing.assert_allclose(found.theta, truth, rtol=0.02, atol=0.02)


def test_an_extra_mode_comes_back() -> None:
    candidate = candidates_of()["extra_mode@tool"]
    middle = {one.name: one.starts[len(one.starts) // 2] for one in candidate.free}
    predictor = predictor_of(candidate)
    truth = np.array([one.encode(middle[one.name]) for one in candidate.free])
    data = made(predictor, truth, 1)
    found = fit(predictor, data, truth + 0.03, 20)
    assert found.chi2 / data.n_values == pytest.approx(1.0, abs=5 * np.sqrt(2 / data.n_values))
    assert np.all(np.abs(found.theta - truth) < 5 * deviations(found))


def test_deviations_cover_the_truth_at_least_as_often_as_they_say() -> None:
    candidate = candidates_of()["coulomb_friction@motor_1"]
    pair = (candidate, candidates_of()["stiffness_error@body_2.rz"])
    predictor = predictor_of(*pair)
    truth = np.array([*encoded(pair[0], level=0.05), *encoded(pair[1], relative=0.04)])
    errors = []
    for seed in range(20):
        found = fit(predictor, made(predictor, truth, seed), truth + 0.1)
        errors.append((found.theta - truth) / deviations(found))
    # 40 parameters, at least about 38 within two standard deviations; those of friction are on the safe side
    assert np.sum(np.abs(errors) < 2) >= 33
    assert 0.3 < np.sqrt(np.mean(np.square(errors))) < 1.5


@pytest.mark.parametrize("factor", [0.02, 20.0])
def test_a_bad_start_ends_at_the_same_minimum(factor: float) -> None:
    candidate = candidates_of()["coulomb_friction@motor_1"]
    predictor, truth = predictor_of(candidate), np.array(encoded(candidate, level=0.05))
    data = made(predictor, truth, 0)
    near, far = fit(predictor, data, truth + 0.1), fit(predictor, data, truth + np.log(factor), 20)
    assert far.converged
    np.testing.assert_allclose(far.theta, near.theta, atol=0.3 * float(deviations(near)[0]))


def test_a_fit_without_iterations_left_says_so() -> None:
    candidate = candidates_of()["coulomb_friction@motor_1"]
    predictor, truth = predictor_of(candidate), np.array(encoded(candidate, level=0.05))
    found = fit(predictor, made(predictor, truth, 0), truth + np.log(20.0), 1)
    assert (found.converged, found.iterations) == (False, 1)


def test_numbers_stay_within_their_bounds() -> None:
    """A stiffness beyond what the effect allows ends at the bound."""
    candidate = candidates_of()["stiffness_error@body_2.rz"]
    narrow = replace(candidate, free=(replace(candidate.free[0], high=0.01, negative=None),))
    data = made(predictor_of(candidate), np.array(encoded(candidate, relative=0.04)), 0)
    found = fit(predictor_of(narrow), data, np.array([-1.0]))
    assert found.theta[0] == 1.0


class TwoAlike:
    """Predictor and log of errors that two parameters change alike, the second by far less and then otherwise."""

    n_effect, bounds, tolerance = 2, (np.full(2, -1.0), np.full(2, 1.0)), Tolerance()
    jumps = False
    fineness = np.ones(2)

    misfit = 1.0

    def residuals(self, _: object, thetas: FloatArray) -> FloatArray:
        noise, alike, other = np.random.default_rng(0).normal(size=(3, 1000, 1))
        far = np.maximum(np.abs(thetas[1]) - 0.01, 0.0)
        return np.asarray(noise + 1e3 * alike * (thetas[0] - 0.01) + 0.03 * alike * thetas[1] + 100 * other * far)


def test_of_two_numbers_that_do_the_same_the_one_moves_that_shows_more() -> None:
    both = TwoAlike()
    found = fit(cast("Predictor", both), cast("FitData", both), np.array([1e-4, -1e-4]), 20)
    assert found.converged
    assert found.theta[0] == pytest.approx(0.01, abs=2e-4)
    assert abs(found.theta[1]) < 0.1


class CurvedValley:
    """Errors that are small along a curve only: predictor and log."""

    n_effect, bounds, tolerance = 2, (np.full(2, -10.0), np.full(2, 10.0)), Tolerance()
    jumps = False
    fineness = np.ones(2)

    misfit, n_values = 1.0, 0

    def residuals(self, _: object, thetas: FloatArray) -> FloatArray:
        noise, across, along = np.random.default_rng(0).normal(size=(3, 1000, 1))
        return np.asarray(noise + 100 * across * (thetas[1] - thetas[0] ** 2) + along * (thetas[0] - 3.0))


def test_steps_follow_a_curved_valley(monkeypatch: pytest.MonkeyPatch) -> None:
    valley = CurvedValley()

    def fitted() -> CandidateFit:
        return fit(cast("Predictor", valley), cast("FitData", valley), np.zeros(2), 40)

    bent = fitted()
    assert bent.converged
    np.testing.assert_allclose(bent.theta, [3.0, 9.0], rtol=0.05)
    monkeypatch.setattr("flexros.gap.fit.least_squares.KEPT", 0.0)
    assert bent.iterations < 0.5 * fitted().iterations


class Bowed:
    """Errors that bend a little with each of many parameters; counts the predictions: predictor and log."""

    tolerance, misfit, settings = Tolerance(), 1.0, DiagnosisSettings(threads=1)

    def __init__(self, number: int, jumps: bool) -> None:
        self.n_effect, self.jumps, self.passes = number, jumps, 0
        self.bounds, self.fineness = (np.full(number, -10.0), np.full(number, 10.0)), np.ones(number)

    def residuals(self, _: object, thetas: FloatArray) -> FloatArray:
        self.passes += 1
        slopes, noise = np.split(np.random.default_rng(0).normal(size=(1000, self.n_effect + 1)), [-1], axis=1)
        far = thetas - np.linspace(0.5, 2.0, self.n_effect)[:, None]
        return np.asarray(noise + 100 * slopes @ (far + 0.1 * far**2))


@pytest.mark.parametrize(("number", "roughly", "jumps"), [(20, False, False), (16, True, False), (16, True, True)])
def test_derivatives_are_not_computed_anew_while_steps_do_what_they_promise(
    number: int, roughly: bool, jumps: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fitted() -> tuple[CandidateFit, int]:
        bowed = Bowed(number, jumps)
        found = fit(cast("Predictor", bowed), cast("FitData", bowed), np.zeros(number), 40, roughly=roughly)
        return found, bowed.passes

    corrected, few = fitted()
    monkeypatch.setattr("flexros.gap.fit.least_squares.LASTING", np.inf)
    anew, many = fitted()
    assert few < many
    assert corrected.converged
    assert corrected.chi2 == pytest.approx(anew.chi2, abs=0.1)
    np.testing.assert_allclose(corrected.theta, anew.theta, atol=1e-3)


def test_derivatives_of_few_parameters_are_exact_unless_fits_are_only_compared() -> None:
    passes = []
    for roughly in (False, True):
        bowed = Bowed(16, False)
        fit(cast("Predictor", bowed), cast("FitData", bowed), np.zeros(16), 40, roughly=roughly)
        passes.append(bowed.passes)
    assert passes[1] < passes[0]


def test_a_fit_that_leaves_much_ends_where_its_steps_hardly_lower_that() -> None:
    valley = CurvedValley()
    predictor, data = cast("Predictor", valley), cast("FitData", valley)
    whole, short = (fit(predictor, data, np.zeros(2), 40, share=share) for share in (0.0, 0.02))
    assert short.converged
    assert short.iterations < whole.iterations
    assert short.chi2 - whole.chi2 < 0.2 * whole.chi2


class Tolerated:
    """Errors of an effect and of one tolerated deviation, which is half a standard deviation: predictor and log."""

    n_effect, bounds, tolerance = 1, (np.full(2, -5.0), np.full(2, 5.0)), Tolerance(("stiffness",), (0.03,))
    jumps = False
    fineness = np.ones(2)

    misfit, settings = 1.0, DiagnosisSettings(threads=1)

    def residuals(self, _: object, thetas: FloatArray) -> FloatArray:
        noise, own, tolerated = np.random.default_rng(0).normal(size=(3, 1000, 1))
        return np.asarray(noise + 100 * own * (thetas[0] - 0.2) + 100 * tolerated * (thetas[1] - 0.5))


def test_slopes_from_elsewhere_that_are_wrong_serve_for_one_step_alone() -> None:
    both, wrong = Tolerated(), -100 * np.random.default_rng(0).normal(size=(3, 1000, 1))[2]
    predictor, data = cast("Predictor", both), cast("FitData", both)
    held = fit(predictor, data, np.zeros(2), 20, tolerance_slopes=wrong)
    first = fit(predictor, data, np.zeros(2), 20, first_slopes=wrong)
    assert held.chi2 > 100 * first.chi2
    np.testing.assert_allclose(first.theta, [0.2, 0.5], atol=0.01)


def test_what_is_tolerated_takes_up_a_deviation_at_its_price() -> None:
    candidate = candidates_of()["stiffness_error@body_2.rz"]
    data = made(predictor_of(candidate), np.array(encoded(candidate, relative=0.04)), 0)
    tolerant = predictor_of(tolerance=Tolerance(("body_2.rz.stiffness",), (0.02,)))
    found = fit(tolerant, data, np.zeros(1))
    assert found.theta[0] == pytest.approx(2.0, abs=0.05)
    residual = data.residuals(tolerant, found.theta[:, None])
    assert found.chi2 == pytest.approx(float(np.sum(residual**2)) + found.theta[0] ** 2)


def test_the_nominal_model_has_nothing_to_fit() -> None:
    nothing = predictor_of()
    found = fit(nothing, data_of(), np.zeros(0))
    assert found.chi2 == pytest.approx(float(chi2_of(nothing, data_of(), np.zeros((0, 1)))[0]))


def test_a_fit_that_is_stopped_ends_where_it_is() -> None:
    candidate = candidates_of()["coulomb_friction@motor_1"]
    predictor, truth = predictor_of(candidate), np.array(encoded(candidate, level=0.05))
    data, start = made(predictor, truth, 0), truth + np.log(20.0)
    found = fit(predictor, data, start, 20, stop=lambda: True)
    assert (found.converged, found.iterations) == (False, 1)
    assert found.chi2 < chi2_of(predictor, data, start[:, None])[0]
