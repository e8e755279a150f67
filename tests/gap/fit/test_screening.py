"""The predicted gain of a candidate in addition to other effects, and its actual gain."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexros.gap.fit.least_squares import fit
from flexros.gap.fit.linearisation import Linearised
from flexros.gap.fit.screening import Surroundings, surroundings_of
from tests.gap.diagnosis_logs import candidates_of, encoded, predictor_of, search_of

TRUTH = ("coulomb_friction@motor_1:level=0.05", "stiffness_error@body_2.rz:relative=0.005")


@pytest.mark.slow
def test_the_missing_effect_gains_as_predicted_and_one_that_is_there_nothing() -> None:
    search = search_of(*TRUTH)
    friction, stiffness = (candidates_of(*TRUTH)[one.partition(":")[0]] for one in TRUTH)
    first = fit(predictor_of(friction), search.data, np.array(encoded(friction, level=0.05)))
    surroundings = search.surroundings(first)

    def predicted(name: str) -> tuple[float, float]:
        (direction,) = search.directions([candidates_of(*TRUTH)[name]])
        scaled, unscaled = surroundings.gains(direction.changes)
        return float(scaled.max()), float(direction.starts[0, np.argmax(unscaled)])

    both = predictor_of(friction, stiffness)
    gained = first.chi2 - fit(both, search.data, np.append(first.theta, 0.0)).chi2
    gain, start = predicted(stiffness.name)
    assert gain > 100
    assert gain == pytest.approx(gained, rel=0.3)
    assert start > 0
    assert predicted(friction.name)[0] < 0.1 * gained


@pytest.mark.slow
def test_what_is_lost_without_an_effect_is_estimated_without_fitting_again() -> None:
    search = search_of(*TRUTH)
    friction, stiffness = (candidates_of(*TRUTH)[one.partition(":")[0]] for one in TRUTH)
    start = np.array([*encoded(friction, level=0.05), *encoded(stiffness, relative=0.005)])
    both = fit(predictor_of(friction, stiffness), search.data, start)
    without_friction, without_stiffness = search.removals(both, search.surroundings(both))
    for rest, name in ((without_friction, friction.name), (without_stiffness, stiffness.name)):
        lost = search.without(both, name).chi2 - both.chi2
        assert rest.least - both.chi2 == pytest.approx(lost, rel=0.3)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("error", [1e200, np.nan])
def test_what_runs_away_without_an_effect_leaves_more_than_anything(error: float) -> None:
    nothing = np.zeros(1)
    fitted = Surroundings(np.ones(3), np.ones((3, 1)), nothing, nothing, 1.0)
    rest = fitted.without(np.array([False]), np.array([0.0, error, 0.0]))
    assert max(rest.least, fitted.least) == max(fitted.least, rest.least) == np.inf


def test_of_directions_that_do_the_same_one_is_selected() -> None:
    rng = np.random.default_rng(1)
    first, second, residual = rng.normal(size=(3, 500))
    residual -= 3 * first + 2 * second
    changes = np.stack([first, first + 0.1 * second, second], axis=-1)
    around = Surroundings(residual, np.zeros((500, 0)), np.zeros(0), np.zeros(0), 1.0)
    assert around.independent(changes, most=6, kept=0.5) == [0, 2]
    assert around.independent(changes, most=1, kept=0.5) == [0]


def test_directions_that_are_fitted_together_have_the_sizes_that_were_left_out() -> None:
    rng = np.random.default_rng(3)
    slopes, changes = rng.normal(size=(400, 2)), rng.normal(size=(400, 3))
    residual = slopes @ [1.0, -2.0] - changes @ [0.5, 3.0, -1.0]
    around = Surroundings(residual, slopes, np.zeros(2), np.zeros(2), 1.0)
    np.testing.assert_allclose(around.sizes(changes), [0.5, 3.0, -1.0])
    assert around.left(changes) == pytest.approx(0.0, abs=1e-6 * around.least)


def test_a_parameter_is_as_much_alike_a_direction_as_their_sizes_are_correlated_in_fits() -> None:
    rng = np.random.default_rng(4)
    slopes, other = rng.normal(size=(400, 2)), rng.normal(size=400)
    around = Surroundings(rng.normal(size=400), slopes, np.zeros(2), np.zeros(2), 1.0)
    direction = 2 * slopes[:, 0] + slopes[:, 1] + 0.5 * other
    every = np.column_stack([slopes, direction])
    expected = np.linalg.inv(every.T @ every)
    expected = expected[0, 2] ** 2 / (expected[0, 0] * expected[2, 2])
    assert expected > 0.9
    assert around.alike(0, direction) == pytest.approx(expected)
    assert around.alike(0, other) < 0.02


@pytest.mark.parametrize(("deviation", "held"), [(5.0, True), (4.0, False)])
def test_a_candidate_gains_what_a_pinned_tolerance_cannot(deviation: float, held: bool) -> None:
    """A tolerated parameter that would go on beyond its bound must not pretend to gain what a candidate gains."""
    rng = np.random.default_rng(2)
    slope = rng.normal(size=400)
    residual = rng.normal(size=400) - 10.0 * slope
    line = Linearised(0.0, residual, slope[:, None], np.array([slope @ residual]), np.array([[slope @ slope]]))
    predictor: Any = SimpleNamespace(n_effect=0, bounds=(np.array([-5.0]), np.array([5.0])))
    pinned: Any = SimpleNamespace(predictor=predictor, theta=np.array([deviation]))
    (scaled,), (unscaled,) = surroundings_of(pinned, line, np.arange(400)).gains(9.9 * slope[:, None])
    removed = float(residual @ residual - (residual + 9.9 * slope) @ (residual + 9.9 * slope))
    assert unscaled == pytest.approx(removed) if held else unscaled < 0.1 * removed
    assert scaled > 0.9 * removed if held else scaled < 0.1 * removed


def test_the_best_set_of_two_directions_is_found_where_each_imitator_gains_more_than_one_of_them() -> None:
    rng = np.random.default_rng(2)
    first, second, third, noise = rng.normal(size=(4, 500))
    residual = noise - 3 * first - 3 * second
    changes = np.stack([first + second + 0.3 * third, first, second, first - third, second - third], axis=-1)
    around = Surroundings(residual, np.zeros((500, 0)), np.zeros(0), np.zeros(0), 1.0)
    assert int(np.argmax(around.gains(changes)[0])) == 0
    assert around.best_sets(changes, 2) == [(0,), (1, 2)]
    assert around.left(changes[:, (1, 2)]) < around.left(changes[:, (0, 3)])


def test_a_part_of_a_known_set_counts_although_no_smaller_one_leads_to_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("flexros.gap.fit.screening.BEAM", 1)
    rng = np.random.default_rng(3)
    parts = rng.normal(size=(6, 500))
    whole = parts[:3].sum(axis=0)
    decoys = [whole + parts[3], whole - parts[3] + parts[4]]
    changes = np.stack([*parts[:3], *decoys, parts[5]], axis=-1)
    around = Surroundings(-whole, np.zeros((500, 0)), np.zeros(0), np.zeros(0), 1.0)
    assert around.best_sets(changes, 3)[-1] != (0, 1, 2)
    assert around.best_sets(changes, 3, (0, 1, 2, 5))[-1] == (0, 1, 2)


def test_a_fit_without_some_parameters_is_that_of_the_others() -> None:
    rng = np.random.default_rng(5)
    slopes, residual, change = rng.normal(size=(400, 3)), rng.normal(size=400), rng.normal(size=400)
    prior, pulled = np.array([0.0, 2.0, 5.0]), np.array([0.0, 1.0, -1.0])
    rest = Surroundings(residual, slopes, prior, pulled, 1.5).without(np.array([True, False, False]), change)
    alone = Surroundings(residual + change, slopes[:, 1:], prior[1:], pulled[1:], 1.5)
    assert rest.known is not None
    np.testing.assert_allclose(rest.known, 1.5 * slopes[:, 1:].T @ slopes[:, 1:] + np.diag(prior[1:]))
    assert replace(rest, known=4 * rest.known).fall == pytest.approx(rest.fall / 4)
    changes = rng.normal(size=(400, 4))
    np.testing.assert_allclose(rest.gains(changes), alone.gains(changes))
    assert rest.least == pytest.approx(alone.least)
