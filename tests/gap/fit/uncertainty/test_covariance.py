"""Covariance of a fit: honest beyond what white errors of a right law show."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.fit.candidate_fit import CandidateFit
from flexros.gap.fit.estimates import parameters_of
from flexros.gap.fit.least_squares import fit
from flexros.gap.fit.sum_of_squares import chi2_of
from flexros.gap.fit.uncertainty import coloured_errors, covariance
from flexros.gap.fit.uncertainty.covariance import fit_covariance
from flexros.gap.settings import FitSettings, RankingSettings
from tests.gap.diagnosis_logs import WHOLE, candidates_of, data_of, encoded, predictor_of

pytestmark = pytest.mark.slow

LEVEL = 0.03


def test_deviations_of_a_fit_that_nearly_diverges_are_finite(
    fitted: CandidateFit, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(coloured_errors, "smoothed", lambda power: np.full_like(power, np.inf))
    data = data_of()
    with np.errstate(invalid="ignore"):
        (friction, _) = parameters_of(replace(fitted), data)
    assert np.isfinite(friction["level"].std)


def test_model_form_errors_of_effects_widen_the_deviations_of_all_sizes() -> None:
    """A large effect of slightly other form than the true one moves the small one that is fitted beside it."""
    large = [f"coulomb_friction@motor_1:level={LEVEL}", "torque_bias@motor_1:level=0.001"]
    among = candidates_of(*large)
    pair = [among["coulomb_friction@motor_1"], among["torque_bias@motor_1"]]
    data = data_of(*large)
    predictor = predictor_of(*pair)
    start = np.array([*encoded(pair[0], level=LEVEL), *encoded(pair[1], level=0.001)])
    found = fit(predictor, data, start, 20, enough=FitSettings().exactly)

    def deviations(form: RankingSettings | None) -> list[float]:
        return [next(iter(one.values())).std for one in parameters_of(found, data, form)]

    assert np.all(np.array(deviations(RankingSettings())) > deviations(None))
    limited, free = (RankingSettings(form_over_rest=most) for most in (0.1, 1e9))  # what is left limits them
    assert np.all(np.array(deviations(limited)) < deviations(free))
    without = RankingSettings(plain_form=0.0, shaped_form=0.0)
    np.testing.assert_allclose(deviations(without), deviations(None))


def test_sizes_of_hysteresis_allow_for_laws_of_other_shapes_on_measured_logs() -> None:
    """Sizes that move with the shape are known no better than laws such as that of Dahl leave them."""
    entry = "hysteresis@motor_1:level=2e-3,angle=1e-4,spread=1.0"
    candidate = candidates_of(entry)["hysteresis@motor_1"]
    data = data_of(entry, length=WHOLE)
    start = np.array(encoded(candidate, level=2e-3, angle=1e-4, spread=1.0))
    found = fit(predictor_of(candidate), data, start, 3, enough=FitSettings().exactly)
    measured = replace(data, record=replace(data.record, imported=True))
    (ours,), (theirs,) = (parameters_of(found, one, RankingSettings()) for one in (data, measured))
    assert theirs["spread"].std == pytest.approx(0.5, rel=0.05)
    assert theirs["angle"].std > 1.4 * ours["angle"].std


def test_friction_that_grows_is_known_no_better_on_a_measured_log_than_it_varies() -> None:
    """One level for all of a log on which it rises by a half is right nowhere, however long the log is."""
    level, drift = f"coulomb_friction@motor_1:level={LEVEL}", f"coulomb={0.5 * LEVEL},time_constant=4"
    candidate = candidates_of(level)["coulomb_friction@motor_1"]
    start, widths = np.array(encoded(candidate, level=1.3 * LEVEL)), []
    for effects_of_log in ((level,), (level, f"friction_drift@motor_1:{drift}")):
        data = data_of(*effects_of_log)
        found = fit(predictor_of(candidate), data, start, 20, enough=FitSettings().exactly)
        measured = replace(data, record=replace(data.record, imported=True))
        widths.append(parameters_of(found, measured, RankingSettings())[0]["level"].std / LEVEL)
    steady, rising = widths
    assert steady < 0.02
    assert 0.04 < rising < 0.5


def test_a_size_that_the_whole_log_shows_stays_determined(monkeypatch: pytest.MonkeyPatch) -> None:
    """Parts may tell next to nothing where sizes have a common factor; the whole log says that the effect is there."""
    candidate = candidates_of(f"coulomb_friction@motor_1:level={LEVEL}")["coulomb_friction@motor_1"]
    data = data_of(f"coulomb_friction@motor_1:level={LEVEL}")
    found = fit(predictor_of(candidate), data, np.array(encoded(candidate, level=LEVEL)), 20)
    monkeypatch.setattr(covariance, "variation_between_parts", lambda *_: np.array([np.inf]))
    measured = replace(data, record=replace(data.record, imported=True))
    size = parameters_of(found, measured, RankingSettings())[0]["level"]
    assert size.determined
    assert size.std == pytest.approx(0.9 * size.value)


def test_a_tolerated_number_varies_by_no_more_than_its_tolerance(
    fitted: CandidateFit, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is known that well without any log. A rotor was known to a millionth where its motor had an unknown law."""
    friction = candidates_of()["coulomb_friction@motor_1"]
    predictor = predictor_of(friction, tolerance=Tolerance(("body_2.rz.stiffness",), (0.03,)))
    theta = np.array([*encoded(friction, level=LEVEL), 0.5])
    widths = []
    for varying in (0.0, 0.1, np.inf):
        monkeypatch.setattr(covariance, "variation_between_parts", lambda *_, by=varying: np.array([0.0, by]))
        data = data_of(f"coulomb_friction@motor_1:level={LEVEL}")
        measured = replace(data, record=replace(data.record, imported=True))
        fit = CandidateFit(predictor, theta, float(chi2_of(predictor, measured, theta[:, None])[0]))
        widths.append(float(np.sqrt(fit_covariance(fit, measured, RankingSettings())[1, 1])))
    assert widths[1] == pytest.approx(np.hypot(widths[0], 0.1))
    assert widths[2] == pytest.approx(1.0)


def test_a_number_that_a_log_says_nothing_of_keeps_its_tolerance_however_the_prior_weighs(
    fitted: CandidateFit, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The prior of a measured log weighs as much as what first effects leave: a gain was 10 times too certain."""
    data = data_of()
    rng, rows = np.random.default_rng(1), data.spread.size
    J = np.column_stack([rng.standard_normal((rows, 2)), np.zeros(rows)])
    for misfit in (1.0, 100.0):
        line = SimpleNamespace(slopes=J, residual=np.zeros(rows), information=J.T @ J + np.diag([0.0, 0.0, misfit]))
        monkeypatch.setattr(covariance, "linearised", lambda *_, line=line: line)
        assert np.sqrt(fit_covariance(replace(fitted), replace(data), None)[2, 2]) == pytest.approx(1.0)


def test_tolerated_numbers_that_are_not_fitted_widen_the_sizes_that_they_look_like() -> None:
    """No log informs of the inertia of a body beside that of a rotor at low frequency, and the rotor seemed certain."""
    candidate, data, form = candidates_of()["motor_inertia_error@motor_1"], data_of(), RankingSettings()
    names, theta = ("body_1.inertia.zz", "body_1.mass"), encoded(candidate, relative=0.2)
    widths = []
    for directions in (np.eye(2), np.empty((2, 0))):
        predictor = predictor_of(candidate, tolerance=Tolerance(names, (0.1, 0.1), directions=directions))
        whole = np.array([*theta, *np.zeros(predictor.tolerance.n_free)])
        fit = CandidateFit(predictor, whole, float(chi2_of(predictor, data, whole[:, None])[0]))
        widths.append([parameters_of(fit, data, one)[0]["relative"].std for one in (form, None)])
    (fitted, _), (considered, ignored) = widths
    assert considered > 0.9 * fitted
    assert considered > 1.5 * ignored
