"""Explaining a log: effects are added for as long as they remove what is left, and no longer."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from flexros.gap.deadline import Deadline
from flexros.gap.fit.candidate_fit import CandidateFit
from flexros.gap.search import forward_selection
from flexros.gap.search.elimination.reduce import reduced
from flexros.gap.search.exchange import corrected, exchanged
from flexros.gap.search.fits.candidate_fits import Search
from flexros.gap.search.forward_selection import Explanations, explain
from flexros.gap.search.growth import with_more
from flexros.gap.search.model_probability import RANKING
from flexros.gap.search.worth import compared
from flexros.record.premises import MEASURED
from tests.gap.diagnosis_logs import search_of

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from flexros.gap.search.fits.additions import Addition

pytestmark = pytest.mark.slow

FRICTION, SOFT = "coulomb_friction@motor_1:level=0.05", "stiffness_error@body_2.rz:relative=-0.05"
SOME = ("coulomb_friction", "stiffness_error", "motor_inertia_error", "torque_bias")


@cache
def explained(*effects: str, among: tuple[str, ...] = SOME) -> tuple[Search, Explanations]:
    """Explain a log with these effects; tests that look at the same answer share it."""
    search = search_of(*effects, among=among)
    return search, explain(search)


def names(found: Explanations) -> set[str]:
    return set(found.chosen.names)


def test_without_gap_the_nominal_model_is_chosen() -> None:
    found = explain(search_of(among=SOME))
    assert not found.detected
    assert names(found) == set()
    assert found.remainder == 0.0


def test_one_effect_is_enough_where_one_is_there() -> None:
    found = explained(FRICTION)[1]
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


def test_a_crowd_of_effects_is_found_together() -> None:
    """Each removes only a part of the gap at first; at the end nothing is left, and nothing is added."""
    crowd = (
        "coulomb_friction@motor_1:level=0.05",
        "viscous_friction@motor_1:coefficient=0.002",
        "stiffness_error@body_2.rz:relative=-0.05",
        "stiffness_error@body_3.rz:relative=0.04",
        "torque_bias@motor_1:level=0.02",
    )
    found = explain(search_of(*crowd, among=(*SOME, "viscous_friction", "torque_gain_error")))
    assert names(found) == {name.partition(":")[0] for name in crowd}
    assert found.remainder == 0.0


def test_candidates_that_fit_badly_from_their_common_start_are_tried_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Initial values of several, each the best one alone, may end in another minimum; the search goes on with one."""
    together, groups = Search.together, []

    def far_off(search: Search, fit: CandidateFit, additions: Sequence[Addition], **others: Any) -> CandidateFit:
        found = together(search, fit, additions, **others)
        groups.append(len(additions))
        return replace(found, chi2=2 * fit.chi2) if len(additions) > 1 else found

    monkeypatch.setattr(Search, "together", far_off)
    crowd = (FRICTION, SOFT, "torque_bias@motor_1:level=0.02")
    found = explain(search_of(*crowd, among=("coulomb_friction", "stiffness_error", "torque_bias")))
    assert max(groups) > 1
    assert names(found) == {name.partition(":")[0] for name in crowd}


def test_candidates_are_tried_alone_where_a_group_removes_less_than_it_must(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where little is left an effect must remove most of it: a group that spoils the best of its members does not."""
    together, alone = Search.together, []

    def spoilt(search: Search, fit: CandidateFit, additions: Sequence[Addition], **others: Any) -> CandidateFit:
        found = together(search, fit, additions, **others)
        if len(additions) > 1:  # removes a half
            return replace(found, chi2=fit.chi2 - 0.5 * (fit.chi2 - search.data.n_values))
        alone.append(found.names)
        return found

    monkeypatch.setattr(Search, "together", spoilt)
    monkeypatch.setattr("flexros.gap.search.growth._removed", lambda *_: 0.6)
    search = search_of(FRICTION, SOFT, among=SOME)
    found = with_more(search, search.null.fit, search.directions(search.candidates()), [])
    assert alone
    assert found is not None
    assert len(found.hypothesis) == 1


@pytest.mark.parametrize("exchange", [exchanged, corrected])
def test_an_effect_that_was_taken_for_another_one_is_exchanged(exchange: Callable[..., CandidateFit]) -> None:
    search = search_of(FRICTION, SOFT, among=(*SOME, "viscous_friction"))
    directions = search.directions(search.candidates())
    by_name = {direction.candidate.name: direction for direction in directions}
    wrong = search.singles([by_name["viscous_friction@motor_1"]])[0]
    second = search.additions([by_name[SOFT.partition(":")[0]]], wrong, search.surroundings(wrong))
    fit = exchange(search, search.together(wrong, second), directions, [])
    assert fit.names == {name.partition(":")[0] for name in (FRICTION, SOFT)}


def test_a_further_effect_that_removes_little_is_refused() -> None:
    """The cause, friction, is not among the candidates: further ones of the others remove little."""
    found = explain(search_of(FRICTION, among=SOME[1:]))
    assert len(names(found)) <= 1
    assert found.remainder > RANKING.unexplained


def test_what_ends_at_a_limit_when_another_effect_is_left_out_is_no_finding(monkeypatch: pytest.MonkeyPatch) -> None:
    search = search_of(FRICTION, among=SOME)
    among = {one.name: one for one in search.candidates()}

    def at_limit(name: str) -> CandidateFit:
        (free,) = among[name].free
        narrow = replace(among[name], free=(replace(free, high=1.01 * free.low),))
        predictor = search.null.predictor((narrow,))
        return CandidateFit(predictor, np.array([narrow.free[0].bounds[1]]), 0.5 * search.null.fit.chi2)

    first, second = at_limit("stiffness_error@body_2.rz"), at_limit("torque_bias@motor_1")
    monkeypatch.setattr(forward_selection, "_best_within_limits", lambda *_: second)
    explanations = Explanations(compared(search, [first]), first, (first,), np.ones(1), detected=True)
    found = forward_selection._pruned(search, explanations)
    assert not found.detected
    assert found.chosen is search.null.fit


def test_rivals_are_no_richer_than_what_was_chosen() -> None:
    found = explained(FRICTION)[1]
    assert max(len(one.predictor.hypothesis) for one in found.rivals) == 1
    assert sum(not one.predictor.hypothesis for one in found.rivals) == 1


def test_what_ended_at_a_limit_is_no_rival_of_what_did_not(monkeypatch: pytest.MonkeyPatch) -> None:
    search, found = explained(FRICTION)
    other = next(one for one in found.comparison.fits if one.names != found.chosen.names and one.hypothesis)
    better = replace(other, chi2=0.9 * found.chosen.chi2)
    comparison = compared(search, [found.chosen, better])
    again = forward_selection.explanations_of(search, comparison, found.chosen, detected=True)
    assert any(one is better for one in again.rivals)
    monkeypatch.setattr(forward_selection, "at_limits", lambda fit: [1] if fit is better else [])
    again = forward_selection.explanations_of(search, comparison, found.chosen, detected=True)
    assert not any(one is better for one in again.rivals)


def test_an_explanation_within_a_number_that_the_chosen_one_names_is_no_rival(monkeypatch: pytest.MonkeyPatch) -> None:
    search, found = explained(FRICTION)
    monkeypatch.setattr(type(search), "premises", property(lambda self: MEASURED))
    monkeypatch.setattr(forward_selection, "worth", lambda *_: False)
    monkeypatch.setattr(forward_selection, "strains", lambda *_: False)
    before = forward_selection.explanations_of(search, found.comparison, found.chosen, detected=True)
    assert len(before.rivals) > 2
    monkeypatch.setattr(forward_selection, "strains", lambda *_: True)
    after = forward_selection.explanations_of(search, found.comparison, found.chosen, detected=True)
    assert {one.names for one in after.rivals} == {frozenset(), found.chosen.names}


@pytest.mark.parametrize(("others", "expected"), [(1, True), (2, False)])
def test_a_fit_with_two_other_effects_that_leaves_clearly_more_is_no_rival_of_a_crowd(
    others: int, expected: bool
) -> None:
    search, found = explained(FRICTION, SOFT, "torque_bias@motor_1:level=0.02", among=(*SOME, "damping_error"))
    chosen = found.chosen
    assert len(chosen.names) == 3
    further = [one for one in search.candidates() if one.name not in chosen.names][:others]
    predictor = search.null.predictor((*chosen.hypothesis[: 3 - others], *further))
    behind = replace(chosen, predictor=predictor, theta=np.zeros(predictor.n_fitted), chi2=1.5 * chosen.chi2)
    comparison = compared(search, [chosen, behind])
    found = forward_selection.explanations_of(search, comparison, chosen, detected=True)
    assert any(one is behind for one in found.rivals) == expected


def test_the_largest_effect_of_a_crowd_is_no_doubt_about_a_small_one() -> None:
    search, found = explained(FRICTION, SOFT)
    chosen, friction = found.chosen, search.without(found.chosen, SOFT.partition(":")[0])
    additions = search.additions(
        search.directions(search.candidates(), friction), friction, search.surroundings(friction)
    )
    another = next(one for one in additions if one.candidate.name not in chosen.names)
    rival = replace(search.together(friction, [another]), chi2=1.2 * chosen.chi2)
    comparison = compared(search, [chosen, rival])  # where friction alone was never fitted
    assert comparison.probabilities([chosen, rival])[1] > 0.02  # although it leaves thousands of nats more
    found = forward_selection.explanations_of(search, comparison, chosen, detected=True)
    assert found.rivals[0] is chosen
    assert found.probabilities[0] > 0.99
    assert {fit.names for fit in found.comparison.fits} == {rival.names, chosen.names, chosen.names & rival.names}


def test_what_was_chosen_is_a_rival_also_where_less_explains_as_much(monkeypatch: pytest.MonkeyPatch) -> None:
    search, found = explained(FRICTION)
    monkeypatch.setattr(forward_selection, "simplest", lambda _search, comparison, *_: comparison.null)
    again = forward_selection.explanations_of(search, found.comparison, found.chosen, detected=True)
    assert any(one is found.chosen for one in again.rivals)


def test_without_time_nothing_is_found() -> None:
    found = explain(replace(search_of(FRICTION, among=SOME), deadline=Deadline(interrupted=lambda: True)))
    assert not found.detected
    assert names(found) == set()


@pytest.mark.parametrize("last", ["single effects", "effects together"])
def test_the_best_explanation_so_far_is_the_answer(last: str) -> None:
    """Two effects are there; interrupted after the first item of a step, the best of what was fitted is finished."""
    steps: list[str] = []
    deadline = Deadline(interrupted=lambda: last in steps)
    search = search_of(FRICTION, SOFT, among=SOME)
    found = explain(replace(search, deadline=deadline, progress=lambda step, _: steps.append(step)))
    assert found.detected
    assert "effects exchanged" not in steps
    assert deadline.partial is not None
    assert deadline.partial.reason == "interrupted"
    assert names(found) <= {name.partition(":")[0] for name in (FRICTION, SOFT)}
    assert found.chosen.chi2 < 0.5 * found.null.chi2


@pytest.mark.parametrize("abandoned", [False, True], ids=["time to finish", "no time at all"])
def test_what_is_needless_is_left_out_although_the_time_is_over(abandoned: bool) -> None:
    search = search_of(FRICTION, among=SOME)
    directions = {one.candidate.name: one for one in search.directions(search.candidates())}
    friction = search.singles([directions["coulomb_friction@motor_1"]])[0]
    bias = search.additions([directions["torque_bias@motor_1"]], friction, search.surroundings(friction))
    grown = search.together(friction, bias)
    late = replace(search, deadline=Deadline(interrupted=lambda: True))
    if abandoned:
        late.deadline.abandon()
    assert reduced(late, grown, [friction, grown], 0.4).names == friction.names
