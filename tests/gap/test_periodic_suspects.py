"""Suspects that repeat with the rotor come with the order that the errors of a log show."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.effects import effects
from flexros.gap.fit import starts_of
from flexros.gap.hypothesis import Suspect
from flexros.gap.periodic_suspects import ENTRIES, periodic_suspects
from flexros.gap.predictor import LANES

from .diagnosis_logs import ROBOT, predictor_of, search_of


def found_in(*effect: str) -> list[Suspect]:
    search = search_of(*effect)
    nothing = search.nothing()
    return list(periodic_suspects(ROBOT, search.data, search.residual(nothing), search.states(nothing)))


@pytest.fixture(scope="module")
def of_ripple() -> list[Suspect]:
    return found_in("torque_ripple@motor_1:amplitude=0.02,order=6,phase=0.5")


def test_every_effect_whose_order_is_sought_is_listed_at_every_motor(of_ripple: list[Suspect]) -> None:
    assert {name for name, one in effects().items() if "order" in one.ranges} == {name for name, *_ in ENTRIES}
    assert [(one.effect.name, one.fixed) for one in of_ripple] == [(name, fixed) for name, _, fixed in ENTRIES]
    assert {one.location for one in of_ripple} == {"motor_1"}


def test_ripples_are_constant_or_in_proportion_to_the_torque(of_ripple: list[Suspect]) -> None:
    kinds = [one.fixed for one in of_ripple if one.effect.name == "torque_ripple"]
    assert sorted(kinds) == [(), (("proportional", True),)]


def test_the_best_order_of_one_effect_is_tried_with_the_others(of_ripple: list[Suspect]) -> None:
    """Linear theory ranks the orders of a nonlinear robot otherwise for every place where a wave may enter."""
    orders = [next(free.starts for free in one.free if free.name == "order") for one in of_ripple]
    assert all(orders[0][0] in others for others in orders)
    assert {len(others) for others in orders} == {LANES}


def test_the_wave_that_is_there_starts_with_its_numbers(of_ripple: list[Suspect]) -> None:
    (ripple,) = (one for one in of_ripple if one.effect.name == "torque_ripple" and not one.fixed)
    start = {one.name: one.starts[0] for one in ripple.free}
    assert start["order"] == pytest.approx(6, rel=0.02)
    assert start["amplitude"] == pytest.approx(0.02, rel=0.5)
    assert starts_of(predictor_of(ripple)).shape == (3, len(ripple.free[0].starts))


def test_ripple_in_proportion_to_the_torque_stays_below_it() -> None:
    """A motor that sticks for most of the log leaves errors as large as its torque."""
    for one in found_in("coulomb_friction@motor_1:level=20"):
        low, high = predictor_of(one).bounds
        one.placed({free.name: float(free.decode(np.array(end))) for free, end in zip(one.free, high, strict=True)})
        assert np.all(low <= starts_of(predictor_of(one))[:, 0])
        assert np.all(starts_of(predictor_of(one))[:, 0] <= high + 1e-12)
