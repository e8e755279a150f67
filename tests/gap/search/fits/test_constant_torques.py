"""Constant torques beside friction that differs by direction: each stands for the other where one is missing."""

from __future__ import annotations

import pytest

from flexros.gap.fit.estimates import parameters_of
from flexros.gap.search.fits.candidate_fits import Search
from flexros.gap.search.fits.further import with_constant_torques
from tests.gap.diagnosis_logs import candidates_of, search_of

pytestmark = pytest.mark.slow

UNEVEN = "viscous_friction@motor_1:coefficient=0.02,asymmetry=-0.3"
BIAS = "torque_bias@motor_1:level=0.01"
MUCH = "stiffness_error@body_2.rz:relative=-0.05"
"""What is missing besides: of it, and all that is left, the constant torque removes little."""


def fitted(search: Search, fits: list) -> tuple:
    """Fit the friction alone, then let a constant torque compete."""
    (friction,) = search.singles(search.directions([candidates_of()["viscous_friction@motor_1"]]))
    return friction, with_constant_torques(search, friction, fits)


def test_a_constant_torque_is_found_however_little_of_what_is_left_it_removes() -> None:
    search = search_of(UNEVEN, BIAS, MUCH)
    friction, beside = fitted(search, fits := [])
    assert fits == [beside]
    assert beside.names == friction.names | {"torque_bias@motor_1"}
    n = search.data.n_values
    assert friction.chi2 - beside.chi2 < 0.1 * (friction.chi2 - n)
    (_, bias) = parameters_of(beside, search.data)
    assert bias["level"].value == pytest.approx(0.01, rel=0.1)


def test_friction_that_differs_by_direction_alone_needs_none() -> None:
    friction, beside = fitted(search_of(UNEVEN, MUCH), fits := [])
    assert beside is friction
    assert not fits
