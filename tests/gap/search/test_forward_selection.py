"""Explaining a log: effects are added for as long as they remove what is left, and no longer."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.gap.search.forward_selection import Explanations, explain
from flexros.gap.search.model_probability import RANKING
from tests.gap.diagnosis_logs import search_of

pytestmark = pytest.mark.slow

FRICTION, SOFT = "coulomb_friction@motor_1:level=0.05", "stiffness_error@body_2.rz:relative=-0.05"
SOME = ("coulomb_friction", "stiffness_error", "motor_inertia_error", "torque_bias")


def names(found: Explanations) -> set[str]:
    return set(found.chosen.names)


def test_without_gap_the_nominal_model_is_chosen() -> None:
    found = explain(search_of(among=SOME))
    assert not found.detected
    assert names(found) == set()
    assert found.remainder == 0.0


def test_one_effect_is_enough_where_one_is_there() -> None:
    found = explain(search_of(FRICTION, among=SOME))
    assert found.detected
    assert names(found) == {FRICTION.partition(":")[0]}
    assert found.remainder == 0.0
    assert found.rivals[0] is found.chosen
    assert found.probabilities.sum() == pytest.approx(1.0)
    assert np.all(np.diff(found.probabilities) <= 0)


def test_two_effects_are_chosen_together() -> None:
    found = explain(search_of(FRICTION, SOFT, among=SOME))
    assert names(found) == {name.partition(":")[0] for name in (FRICTION, SOFT)}
    assert found.remainder == 0.0


def test_a_further_effect_that_removes_little_is_refused() -> None:
    """The cause, friction, is not among the candidates: further ones of the others remove little."""
    found = explain(search_of(FRICTION, among=SOME[1:]))
    assert len(names(found)) <= 1
    assert found.remainder > RANKING.unexplained


def test_rivals_are_no_richer_than_what_was_chosen() -> None:
    found = explain(search_of(FRICTION, among=SOME))
    assert max(len(one.predictor.hypothesis) for one in found.rivals) == 1
    assert sum(not one.predictor.hypothesis for one in found.rivals) == 1
