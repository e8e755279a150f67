"""Tests of logs that are tied more loosely to their encoders once an explanation predicts them well."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest

from flexros.effects import RobotWithEffects
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.diagnose import diagnose
from flexros.gap.fit.null_fit import NullFit, fit_null
from flexros.gap.measure_gap import measure_gap
from flexros.gap.residuals.prepare_fit_data import fit_data
from flexros.gap.search.fits.candidate_fits import Search
from flexros.gap.search.forward_selection import Explanations, explain
from flexros.gap.search.looser import found_looser, looser_null
from flexros.gap.search.prepare import prepare_search
from flexros.gap.settings import DiagnosisSettings
from tests.gap.diagnosis_logs import MODEL, ROBOT, record_of, settings_of

NUMBERS = Tolerance(("body_1.rz.stiffness", "motor_1.inertia"), (0.3, 0.3))
LARGE, SMALL = "coulomb_friction@motor_1:level=1", "viscous_friction@motor_1:coefficient=5e-5"


def far_off() -> NullFit:
    """Fit the two numbers of a nominal model that are so far off that the predictor follows the encoders closely."""
    nominal = {name: 0.6 * ROBOT.parameters[name].value for name in NUMBERS.names}
    model = RobotWithEffects(ROBOT.with_values(nominal), ())
    return fit_null(fit_data(record_of(), model, DiagnosisSettings()), model, NUMBERS)


@pytest.mark.slow
def test_numbers_within_tolerance_do_not_decide_how_closely_a_log_is_tied() -> None:
    """On six-axis arms 3 % off, friction that is worth 1600 nats at the least torque noise was worth 40."""
    null, settings = far_off(), DiagnosisSettings()
    assert null.data.torque_noise > null.data.least_torque_noise == settings.level
    found = looser_null(null, record_of(), NUMBERS, settings)
    assert found is not None
    assert found.data.torque_noise == settings.level
    assert found.fit.chi2 / found.data.n_values == pytest.approx(1.0, abs=0.05)
    assert looser_null(found, record_of(), NUMBERS, settings) is None


def test_a_log_that_is_tied_as_its_tolerance_says_stays_so() -> None:
    record = replace(record_of(LARGE), imported=True)
    null = fit_null(fit_data(record, MODEL, DiagnosisSettings()), MODEL, Tolerance())
    assert looser_null(null, record, Tolerance(), DiagnosisSettings()) is None


@cache
def first_search() -> tuple[Search, Explanations]:
    """Search a log whose large effect ties it closely."""
    settings = settings_of("coulomb_friction", "viscous_friction", "torque_bias")
    data = fit_data(record_of(LARGE, SMALL), MODEL, settings)
    search = prepare_search(fit_null(data, MODEL, Tolerance()), settings)
    return search, explain(search)


@pytest.mark.slow
def test_a_search_goes_on_from_an_explanation_in_the_log_tied_more_loosely() -> None:
    search, first = first_search()
    assert search.data.torque_noise > search.data.least_torque_noise
    again, found = found_looser(search, first, record_of(LARGE, SMALL), Tolerance())
    assert again.data.torque_noise == search.data.least_torque_noise
    assert again.resumed
    assert again.of_torques == frozenset()
    assert found.chosen.names > first.chosen.names


@pytest.mark.slow
def test_where_a_looser_tie_shows_what_no_effect_explains_the_explanation_before_stays(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """On a rigid arm what a Stribeck curve of another form left then got a ripple, a drift and Coulomb friction."""
    search, first = first_search()
    monkeypatch.setattr("flexros.gap.search.looser.explain", lambda again: replace(first, chosen=again.null.fit))
    assert found_looser(search, first, record_of(LARGE, SMALL), Tolerance()) == (search, first)


def test_where_no_candidate_adds_in_a_looser_tie_that_shows_more_than_noise_none_is_exchanged(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    search, first = first_search()
    again = replace(search, base=first.chosen, left_before=1.0)
    room = "flexros.gap.search.forward_selection"
    monkeypatch.setattr(f"{room}.extended", lambda _search, chosen, *_: chosen)
    monkeypatch.setattr(f"{room}.in_vain", lambda *_: True)
    monkeypatch.setattr(f"{room}.tidied", lambda *_: pytest.fail("exchanges take longer than all before"))
    assert explain(again).chosen is first.chosen


@pytest.mark.slow
def test_a_small_effect_beside_one_that_is_far_off_is_named() -> None:
    settings = settings_of("coulomb_friction", "viscous_friction", "torque_bias")
    causes = diagnose(record_of(LARGE, SMALL), ROBOT, settings=settings).diagnosis.causes
    found = {cause.effect: cause for cause in causes if cause.probability > 0.5}
    assert found.keys() == {"coulomb_friction", "viscous_friction"}
    assert found["viscous_friction"].parameters["coefficient"].value == pytest.approx(5e-5, rel=0.3)


def test_an_explanation_beside_a_line_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    """The search that found it knew the log without the line; this one would find the line again."""
    search, first = first_search()
    monkeypatch.setattr("flexros.gap.search.looser._looser_search", lambda *_: pytest.fail("it was searched again"))
    beside = replace(first, beside=search.data)
    assert found_looser(search, beside, record_of(LARGE, SMALL), Tolerance()) == (search, beside)


@pytest.mark.slow
def test_a_gap_is_stated_as_it_was_before_the_log_was_tied_more_loosely_too() -> None:
    """One log had three figures: 3.5e6 floors of a diagnosis, and 6.1e5 of an interrupted one and of the gap alone."""
    settings = settings_of("coulomb_friction", "viscous_friction", "torque_bias")
    log, holdout = (record_of(LARGE, SMALL, seed=seed) for seed in (1, 2))
    found = diagnose(log, ROBOT, holdout=holdout, settings=settings).diagnosis.gap
    limited = settings.model_copy(update={"time_limit": 1e-3})
    ended = diagnose(log, ROBOT, holdout=holdout, settings=limited).diagnosis.gap
    assert found.before_alone is not None
    assert found.before > 2 * found.before_alone
    assert (ended.before, ended.before_alone) == (pytest.approx(found.before_alone), None)
    assert measure_gap(holdout, MODEL, settings=settings).numbers.before == pytest.approx(found.before_alone, rel=0.02)
