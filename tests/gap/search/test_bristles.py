"""Bristles of dry friction: found where contacts yield, and sizes beside them are right then."""

from __future__ import annotations

import pytest

from flexros.gap.fit.estimates import parameters_of
from flexros.gap.search.bristles import with_bristles
from flexros.gap.search.fits.candidate_fits import Search
from tests.gap.diagnosis_logs import ROBOT, WHOLE, candidates_of, search_of

pytestmark = pytest.mark.slow

LEVEL, SOFT = 0.05, "stiffness_error@body_2.rz:relative=-0.05"
BEND = 0.2 * float(ROBOT.encoder_noise[0])
YIELDING = f"coulomb_friction@motor_1:level={LEVEL},stiffness={LEVEL / BEND:.6g},damping={1e-3 * LEVEL / BEND:.6g}"


def fitted(search: Search) -> tuple:
    """Fit rigid friction and the softer spring, then let bristles compete."""
    both = search.singles(search.directions([candidates_of()["coulomb_friction@motor_1"]]))[0]
    softer = search.directions([candidates_of()[SOFT.partition(":")[0]]], both)
    rigid = search.together(both, search.additions(softer, both, search.surroundings(both)))
    return rigid, with_bristles(search, rigid, [])


def test_contacts_that_yield_are_found_and_bias_no_other_size() -> None:
    search = search_of(YIELDING, SOFT)
    rigid, held = fitted(search)
    assert held.names == rigid.names
    assert rigid.chi2 - held.chi2 > 100
    friction, spring = parameters_of(held, search.data)
    assert friction["stiffness"].value == pytest.approx(LEVEL / BEND, rel=0.2)
    assert abs(friction["level"].value - LEVEL) < 3 * friction["level"].std
    assert abs(spring["relative"].value + 0.05) < 3 * spring["relative"].std


def test_rigid_contacts_stay_rigid() -> None:
    rigid, held = fitted(search_of(f"coulomb_friction@motor_1:level={LEVEL}", SOFT))
    assert held is rigid


def test_bristles_that_stood_for_another_effect_go_again() -> None:
    search = search_of(f"coulomb_friction@motor_1:level={LEVEL}", SOFT, length=WHOLE)
    (friction, *_) = search.singles(search.directions([candidates_of()["coulomb_friction@motor_1"]]))
    bent = with_bristles(search, friction, fits := [])
    assert [free.name for free in bent.hypothesis[0].free] == ["level", "stiffness", "damping"]
    softer = search.directions([candidates_of()[SOFT.partition(":")[0]]], bent)
    both = search.together(bent, search.additions(softer, bent, search.surroundings(bent)))
    firm = with_bristles(search, both, fits)
    assert [free.name for free in firm.hypothesis[0].free] == ["level"]
    assert firm.names == both.names


def test_the_hump_of_friction_holds_by_bristles_of_its_own() -> None:
    """Those of a small Coulomb level beside it yield by little: a rest of 1,800 nats hid three effects of a crowd."""
    hump = f"stribeck_friction@motor_1:extra={LEVEL},velocity=0.1"
    search = search_of(f"{hump},stiffness={LEVEL / BEND:.6g},damping={1e-3 * LEVEL / BEND:.6g}")
    rigid = search.singles(search.directions([candidates_of()["stribeck_friction@motor_1"]]))[0]
    held = with_bristles(search, rigid, [])
    assert held.names == rigid.names
    assert rigid.chi2 - held.chi2 > 100
    (friction,) = parameters_of(held, search.data)
    assert friction["stiffness"].value == pytest.approx(LEVEL / BEND, rel=0.2)
    assert abs(friction["extra"].value - LEVEL) < 3 * friction["extra"].std
