"""Parameters of an effect that a log does not show stay neutral, the others stay in."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from flexros.gap.fit.candidate_fit import CandidateFit
from flexros.gap.fit.estimates import parameters_of, placed_effects
from flexros.gap.fit.pruning import own_information, without_least_parameter
from flexros.gap.search.fits.candidate_fits import Search
from flexros.gap.search.forward_selection import explain
from tests.gap.diagnosis_logs import FEW_EFFECTS, candidates_of, search_of

pytestmark = pytest.mark.slow

VISCOUS = "viscous_friction@motor_1:coefficient=3e-3"


@cache
def fitted(effect: str, candidate: str) -> tuple[Search, CandidateFit]:
    search = search_of(effect)
    return search, search.singles(search.directions([candidates_of()[candidate]]))[0]


def names(one: CandidateFit) -> list[str]:
    return [free.name for candidate in one.predictor.hypothesis for free in candidate.free]


def test_an_asymmetry_that_is_not_there_is_left_out() -> None:
    search, rich = fitted(VISCOUS, "viscous_friction@motor_1")
    pruned = search.pruned(rich)
    assert names(rich) == ["coefficient", "asymmetry"]
    assert names(pruned) == ["coefficient"]
    assert placed_effects(pruned)[0].effect.model_dump()["asymmetry"] == 0.0
    assert 0 <= pruned.chi2 - rich.chi2 < np.log(search.data.n_values) * rich.chi2 / search.data.n_values
    parameters = parameters_of(pruned)[0]
    assert abs(parameters["coefficient"].value - 3e-3) < 5 * parameters["coefficient"].std


def test_an_asymmetry_that_is_there_stays() -> None:
    search, rich = fitted(f"{VISCOUS},asymmetry=0.3", "viscous_friction@motor_1")
    assert search.pruned(rich) is rich


@pytest.mark.parametrize("candidate", ["torque_bias@motor_1", "coulomb_friction@motor_1"])
def test_an_effect_keeps_what_it_is_there_by(candidate: str) -> None:
    """Neither is in the log: the parameters are nearly zero, but without them the effect would vanish."""
    _, none = fitted(VISCOUS, candidate)
    assert without_least_parameter(none) is None


def test_the_chosen_explanation_has_no_spare_numbers() -> None:
    found = explain(search_of(VISCOUS, among=FEW_EFFECTS))
    assert found.chosen.names == {"viscous_friction@motor_1"}
    assert names(found.chosen) == ["coefficient"]
    assert found.chosen in found.rivals
    assert found.probabilities.sum() == pytest.approx(1.0)


def test_information_is_what_the_other_numbers_leave() -> None:
    """A parameter that the others imitate has none, though its own derivatives are large."""
    slopes = np.random.default_rng(0).normal(size=(50, 3))
    slopes[:, 2] = slopes[:, 0] - 2 * slopes[:, 1]
    information = slopes.T @ slopes
    assert own_information(information, 2) < 1e-9 * information[2, 2]
    apart = slopes[:, :2].T @ slopes[:, :2]
    assert own_information(apart, 0) == pytest.approx(1 / np.linalg.inv(apart)[0, 0])
