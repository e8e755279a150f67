from __future__ import annotations

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.friction.laws import LAWS, fit_law
from flexros.identify.friction.points import FrictionPoints

SPEEDS = np.concatenate([-np.geomspace(2.0, 0.02, 15), np.geomspace(0.02, 2.0, 15)])
TRUE = {
    "viscous and Coulomb": [1.5, 6.0],
    "LuGre, steady": [1.5, 6.0, 3.0, 0.3],
    "Feeny and Moon": [1.5, 9.0, 0.6, 5.0, 80.0],
}


def points(name: str, noise: float) -> FrictionPoints:
    law = next(law for law in LAWS if law.name == name)
    torque = law.evaluate(SPEEDS, np.array(TRUE[name]))
    torque = torque + noise * np.random.default_rng(1).normal(size=len(SPEEDS))
    return FrictionPoints(SPEEDS, torque, np.full(len(SPEEDS), noise), 0.0)


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.equation)
def test_law_is_found_again_within_its_deviations(law) -> None:  # type: ignore[no-untyped-def]
    fit = fit_law(law, points(law.name, 0.02))
    assert np.all(np.abs(fit.values - TRUE[law.name]) < 4 * fit.deviations)
    assert fit.rms == pytest.approx(0.02, rel=0.4)


@pytest.mark.parametrize("true", list(TRUE))
def test_the_true_law_explains_the_points_best(true: str) -> None:
    fits = [fit_law(law, points(true, 0.02)) for law in LAWS]
    assert min(fits, key=lambda fit: fit.criterion).law.name == true


def test_feeny_moon_means_one_over_cosh() -> None:
    """At high speed only the kinetic share mu_k remains; at low speed the whole level."""
    law = LAWS[2]
    p = np.array([0.0, 10.0, 0.6, 5.0, 1e4])
    assert law.evaluate(np.array([10.0]), p)[0] == pytest.approx(6.0, rel=1e-6)
    assert law.evaluate(np.array([1e-3]), p)[0] == pytest.approx(10.0, rel=1e-4)


def test_too_few_speeds_are_refused() -> None:
    few = FrictionPoints(SPEEDS[:4], SPEEDS[:4], SPEEDS[:4], 0.0)
    with pytest.raises(InputError, match="4 constant speeds"):
        fit_law(LAWS[1], few)
