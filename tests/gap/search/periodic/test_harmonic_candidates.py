"""Candidates that repeat with the rotor come with the order that the errors of a log show."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from flexros.effects import effects
from flexros.gap.candidates.candidate import Candidate
from flexros.gap.fit.candidate_fit import CandidateFit
from flexros.gap.fit.initial_values import initial_values
from flexros.gap.fit.linearisation import linearise
from flexros.gap.prediction.predictor import LANES
from flexros.gap.search.periodic import harmonic_candidates
from flexros.gap.search.periodic.harmonic_candidates import _free, neighbouring_orders
from flexros.gap.search.periodic.harmonics import VALLEYS, HarmonicFit
from tests.gap.diagnosis_logs import WHOLE, candidates_of, encoded, predictor_of, search_of

pytestmark = pytest.mark.slow


def found_in(*effect: str) -> list[Candidate]:
    search = search_of(*effect)
    return list(search.harmonics(search.null.fit))


@pytest.fixture(scope="module")
def of_ripple() -> list[Candidate]:
    return found_in("torque_ripple@motor_1:amplitude=0.02,order=6,phase=0.5")


def test_every_effect_whose_order_is_sought_is_listed_at_every_motor(of_ripple: list[Candidate]) -> None:
    periodic = [one for one in effects().values() if "order" in one.ranges]
    assert periodic == [one for one in effects().values() if one.harmonics]
    assert [(one.effect, one.fixed) for one in of_ripple] == [
        (one, way.fixed) for one in periodic for way in one.harmonics
    ]
    assert {one.location for one in of_ripple} == {"motor_1"}


def test_ripples_are_constant_or_in_proportion_to_the_torque(of_ripple: list[Candidate]) -> None:
    kinds = [one.fixed for one in of_ripple if one.effect.name == "torque_ripple"]
    assert sorted(kinds) == [(), (("proportional", True),)]


def test_the_best_order_of_one_effect_is_tried_with_the_others(of_ripple: list[Candidate]) -> None:
    """Linear theory ranks the orders of a nonlinear robot otherwise for every entry where a harmonic may enter."""
    orders = [next(free.starts for free in one.free if free.name == "order") for one in of_ripple]
    assert all(orders[0][0] in others for others in orders)
    assert {len(others) for others in orders} == {LANES}


def test_the_wave_that_is_there_starts_with_its_numbers(of_ripple: list[Candidate]) -> None:
    (ripple,) = (one for one in of_ripple if one.effect.name == "torque_ripple" and not one.fixed)
    starts = [
        dict(zip(("amplitude", "order", "phase"), values)) for values in zip(*(one.starts for one in ripple.free))
    ]
    start = min(starts[:2], key=lambda one: abs(one["order"] - 6))  # linear theory may rank a neighbour first
    assert start["order"] == pytest.approx(6, rel=0.02)
    assert start["amplitude"] == pytest.approx(0.02, rel=0.5)
    assert initial_values(predictor_of(ripple)).shape == (3, len(ripple.free[0].starts))
    search = search_of("torque_ripple@motor_1:amplitude=0.02,order=6,phase=0.5")
    (fit,) = search.singles(search.directions([ripple]))
    found = fit.predictor.values(fit.theta)[0]
    assert found["order"] == pytest.approx(6, abs=0.01)
    assert found["amplitude"] == pytest.approx(0.02, rel=0.1)


def test_the_best_neighbour_of_a_wrong_order_has_the_wave_that_is_there(of_ripple: list[Candidate]) -> None:
    """A sum of squares at the amplitude and phase of the wrong order ranks the right one behind many others."""
    search = search_of("torque_ripple@motor_1:amplitude=0.02,order=6,phase=0.5")
    (ripple,) = (one for one in of_ripple if one.effect.name == "torque_ripple" and not one.fixed)
    predictor, valley = predictor_of(ripple), np.pi / np.ptp(search.data.record.position)
    theta = np.array(encoded(ripple, amplitude=0.005, order=6 - 3 * valley, phase=0.0))
    found = neighbouring_orders(CandidateFit(predictor, theta, 1.0), search.data, search.rows)
    assert found.shape == (3, len(VALLEYS))
    best = predictor.values(found[:, 0])[0]
    assert best["order"] == pytest.approx(6.0, abs=valley / 10)
    assert best["amplitude"] == pytest.approx(0.02, rel=0.2)
    assert best["phase"] == pytest.approx(0.5, abs=0.3)


def test_the_effects_of_an_order_are_listed_in_place_of_each_other() -> None:
    """What has an order is found while much else is missing, and may be a ripple where a transmission error is."""
    search = search_of("transmission_error@motor_1:amplitude=1e-4,order=6,phase=0.5", length=WHOLE)
    ripple = next(one for one in search.harmonics(search.null.fit) if one.effect.name == "torque_ripple")
    (wrong,) = search.singles(search.directions([ripple]))
    order = wrong.predictor.values(wrong.theta)[0]["order"]
    others = search.harmonics_in_place(wrong, ripple)
    assert {one.effect.name for one in others} == {"transmission_error", "encoder_eccentricity"}
    assert {one.free[1].starts for one in others} == {(order,)}
    ((rest,), surroundings) = (search.removals(wrong, search.surroundings(wrong)), search.surroundings(wrong))
    best, *_ = search.additions(search.directions(others, wrong), wrong, rest)
    assert best.candidate.effect.name == "transmission_error"
    assert rest.least - best.gain < surroundings.least


def test_of_an_order_the_derivative_is_that_of_a_small_step(of_ripple: list[Candidate]) -> None:
    """A thousandth of an order turns the phase at a rotor angle of hundreds of rad by more than a radian."""
    (ripple,) = (one for one in of_ripple if one.effect.name == "torque_ripple" and not one.fixed)
    predictor, data = predictor_of(ripple), search_of().data
    far = 1e-3 * np.ptp(data.record.position)
    theta = np.array(encoded(ripple, amplitude=0.02, order=6.0 / far, phase=0.5))
    slope = linearise(predictor, data, theta).slopes[:, 1]
    step = 1e-7
    pair = np.stack([theta, theta], axis=-1) + step * np.array([[0, 0], [1, -1], [0, 0]])
    first, second = data.residuals(predictor, pair).T
    np.testing.assert_allclose(slope, (first - second) / (2 * step), atol=0.02 * np.abs(slope).max())


def test_starts_keep_the_other_effects_and_phases_far_from_their_limits(of_ripple: list[Candidate]) -> None:
    (ripple,) = (one for one in of_ripple if one.effect.name == "torque_ripple" and not one.fixed)
    friction, search = candidates_of()["coulomb_friction@motor_1"], search_of()
    predictor = predictor_of(friction, ripple)
    theta = np.array([0.1, *encoded(ripple, amplitude=0.01, order=6.0, phase=3.0)])
    for start in neighbouring_orders(CandidateFit(predictor, theta, 1.0), search.data, search.rows).T:
        assert start[0] == theta[0]
        assert abs(predictor.values(start)[1]["phase"]) <= np.pi
    alone = CandidateFit(predictor_of(friction), theta[:1], 1.0)
    assert neighbouring_orders(alone, search.data, search.rows).shape == (1, 0)


def test_a_fit_at_a_neighbouring_order_finds_the_true_one() -> None:
    """A wave that is one turn off over the whole way of the rotor fits best among its neighbours, but not well."""
    search = search_of("torque_ripple@motor_1:amplitude=0.02,order=6,phase=0.5")
    ripple = next(one for one in search.harmonics(search.null.fit) if one.effect.name == "torque_ripple")
    way = float(np.ptp(search.data.record.position))
    off = replace(ripple.free[1], starts=tuple(start + 2 * np.pi / way for start in ripple.free[1].starts[:1]))
    amplitude, phase = (replace(one, starts=one.starts[:1]) for one in (ripple.free[0], ripple.free[2]))
    (found,) = search.singles(search.directions([replace(ripple, free=(amplitude, off, phase))]))
    assert found.predictor.values(found.theta)[0]["order"] == pytest.approx(6.0, abs=0.01)


def test_ripple_in_proportion_to_the_torque_stays_below_it() -> None:
    """A motor that sticks for most of the log leaves errors as large as its torque."""
    largest = {}
    for one in found_in("coulomb_friction@motor_1:level=20"):
        low, high = predictor_of(one).bounds
        start = initial_values(predictor_of(one))[:, 0]
        assert np.all(low <= start)
        assert np.all(start <= high + 1e-12)
        ends = {free.name: float(free.decode(np.array(end))) for free, end in zip(one.free, high, strict=True)}
        largest[one.effect.name, one.fixed] = one.placed(ends).effect.model_dump()["amplitude"]
    assert largest["torque_ripple", (("proportional", True),)] == pytest.approx(0.99)
    assert largest["torque_ripple", ()] > 1


def test_nothing_is_next_to_a_fit_without_parameters() -> None:
    search = search_of("torque_ripple@motor_1:amplitude=0.02,order=6,phase=0.5")
    found = neighbouring_orders(CandidateFit(predictor_of(), np.zeros(0), 1.0), search.data, search.rows)
    assert found.shape == (0, 0)


def test_orders_whose_prediction_diverges_are_no_neighbours(
    of_ripple: list[Candidate], monkeypatch: pytest.MonkeyPatch
) -> None:
    search = search_of("torque_ripple@motor_1:amplitude=0.02,order=6,phase=0.5")
    (ripple,) = (one for one in of_ripple if one.effect.name == "torque_ripple" and not one.fixed)
    fit = CandidateFit(predictor_of(ripple), np.array(encoded(ripple, amplitude=0.005, order=6, phase=0.0)), 1.0)
    changes_of = harmonic_candidates.changes_of

    def diverging(*arguments: Any) -> np.ndarray:
        changes = changes_of(*arguments)
        changes[:, 3] = np.inf
        return changes

    monkeypatch.setattr(harmonic_candidates, "changes_of", diverging)
    assert neighbouring_orders(fit, search.data, search.rows).shape == (3, len(VALLEYS) - 1)


@pytest.mark.parametrize(("lowest", "expected"), [(0.0, 0.02), (0.05, 0.05), (0.1, 0.06)])
def test_an_order_moves_down_to_the_lowest_that_a_measured_log_shows(lowest: float, expected: float) -> None:
    """A wave as long as the travel of a gantry stood for the chain of its cables, and drew two more false names."""
    (_, order, _) = _free([HarmonicFit(order, 1.0, 0.0, 10.0) for order in (0.06, 0.3)], 10.0, lowest)
    assert (order.low, order.high) == (pytest.approx(expected), pytest.approx(0.9))
