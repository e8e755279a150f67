"""Candidates that repeat with the rotor come with the order that the errors of a log show."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.effects import effects
from flexros.gap.candidates.candidate import Candidate
from flexros.gap.fit.least_squares import CandidateFit, initial_values
from flexros.gap.prediction.predictor import LANES
from flexros.gap.search.harmonic_candidates import VALLEYS, neighbouring_orders
from tests.gap.diagnosis_logs import candidates_of, predictor_of, record_of, search_of

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
    start = {one.name: one.starts[0] for one in ripple.free}
    assert start["order"] == pytest.approx(6, rel=0.02)
    assert start["amplitude"] == pytest.approx(0.02, rel=0.5)
    assert initial_values(predictor_of(ripple)).shape == (3, len(ripple.free[0].starts))


def test_neighbouring_orders_have_the_same_harmonic_in_the_middle_or_its_opposite(
    of_ripple: list[Candidate],
) -> None:
    (ripple,) = (one for one in of_ripple if one.effect.name == "torque_ripple" and not one.fixed)
    friction = candidates_of()["coulomb_friction@motor_1"]
    predictor, record = predictor_of(friction, ripple), record_of()
    theta = np.array([0.0, *(one.encode(one.starts[0]) for one in ripple.free)])
    found = neighbouring_orders(CandidateFit(predictor, theta, 1.0), record)
    first, middle = predictor.values(theta)[1], float(np.mean(record.position))
    assert found.shape == (4, 2 * len(VALLEYS))
    for start in found.T:
        np.testing.assert_array_equal(start[:2], theta[:2])
        other = predictor.values(start)[1]
        turned = (other["order"] - first["order"]) * middle + other["phase"] - first["phase"]
        assert np.sin(turned) == pytest.approx(0.0, abs=1e-9)
        assert 0 < abs(other["order"] - first["order"]) * np.ptp(record.position) < 9 * np.pi
    assert neighbouring_orders(CandidateFit(predictor_of(friction), theta[:1], 1.0), record).shape == (1, 0)


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
    for one in found_in("coulomb_friction@motor_1:level=20"):
        low, high = predictor_of(one).bounds
        one.placed({free.name: float(free.decode(np.array(end))) for free, end in zip(one.free, high, strict=True)})
        assert np.all(low <= initial_values(predictor_of(one))[:, 0])
        assert np.all(initial_values(predictor_of(one))[:, 0] <= high + 1e-12)
