"""Explaining a log: effects are added for as long as they remove what is left, and no longer."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from flexros.gap.search import candidate_fits as search_module
from flexros.gap.search.forward_selection import Explanations, explain
from flexros.gap.search.model_probability import UNEXPLAINED
from tests.gap.diagnosis_logs import candidates_of, search_of

FRICTION, SOFT = "coulomb_friction@motor_1:level=0.05", "stiffness_error@body_2.rz:relative=-0.05"
SOME = ("coulomb_friction@motor_1", "stiffness_error@body_2.rz", "motor_inertia_error@motor_1", "torque_bias@motor_1")


@pytest.fixture(autouse=True)
def few_candidates(monkeypatch: pytest.MonkeyPatch) -> None:
    """Look for some effects only, which makes searches short."""
    some = [candidates_of()[name] for name in SOME]
    monkeypatch.setattr(search_module, "list_candidates", lambda *_: some)
    monkeypatch.setattr(search_module, "harmonic_candidates", lambda *_: ())


def names(found: Explanations) -> set[str]:
    return {candidate.name for candidate in found.chosen.predictor.hypothesis}


def test_without_gap_the_nominal_model_is_chosen() -> None:
    found = explain(search_of())
    assert not found.detected
    assert names(found) == set()
    assert found.left == 0.0


def test_one_effect_is_enough_where_one_is_there() -> None:
    found = explain(search_of(FRICTION))
    assert found.detected
    assert names(found) == {SOME[0]}
    assert found.left == 0.0
    assert found.rivals[0] is found.chosen
    assert found.probabilities.sum() == pytest.approx(1.0)
    assert np.all(np.diff(found.probabilities) <= 0)


def test_two_effects_are_chosen_together() -> None:
    found = explain(search_of(FRICTION, SOFT))
    assert names(found) == set(SOME[:2])
    assert found.left == 0.0


def test_a_further_effect_that_removes_little_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """The cause, friction, is not among the candidates: what is beside the best of the others removes little."""
    others: Sequence[str] = SOME[1:]
    monkeypatch.setattr(search_module, "list_candidates", lambda *_: [candidates_of()[name] for name in others])
    found = explain(search_of(FRICTION))
    assert len(names(found)) <= 1
    assert found.left > UNEXPLAINED


def test_rivals_are_no_richer_than_what_was_chosen() -> None:
    found = explain(search_of(FRICTION))
    assert max(len(one.predictor.hypothesis) for one in found.rivals) == 1
    assert sum(not one.predictor.hypothesis for one in found.rivals) == 1
