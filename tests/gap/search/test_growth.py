"""Growth of an explanation ends where the same set of effects comes again."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexros.gap.fit.screening import Surroundings
from flexros.gap.search import growth
from flexros.gap.settings import DiagnosisSettings
from flexros.record.premises import MEASURED, SIMULATED

N = 20_000


def fit(*names: str) -> Any:
    return SimpleNamespace(
        names=frozenset(names),
        hypothesis=names,
        converged=True,
        deviations=(),
        predictor=SimpleNamespace(n_effect=len(names)),
        chi2=100.0 - len(names),
    )


def search_that_never_ends() -> Any:
    return SimpleNamespace(
        settings=DiagnosisSettings(),
        torques_decide=False,
        resumed=False,
        premises=SIMULATED,
        data=SimpleNamespace(n_values=10, torque_noise=1.0, least_torque_noise=1.0),
        deadline=SimpleNamespace(stops=lambda: False),
        within_limits=lambda one: one,
    )


@pytest.fixture
def steps(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Steps of a search in which a further effect takes the place of the one before, always."""
    taken: list[str] = []
    nothing = SimpleNamespace(score=lambda one: 0.0, threshold=0.0)
    patches = {
        "with_constant_torques": lambda _search, one, _fits: one,
        "with_bristles": lambda _search, one, _fits: one,
        "with_overtones": lambda _search, one, _fits: one,
        "compared": lambda *_: nothing,
        "best_of_each": lambda fits: fits,
        "incomplete": lambda *_: True,
        "floor_is_uncertain": lambda *_: False,
        "worth": lambda *_: True,
        "from_nominal_numbers": lambda *_: None,
        "draws_numbers": lambda *_: False,
        "with_usual": lambda *_: None,
        "_removed": lambda *_: 0.1,
        "corrected": lambda _search, one, *_: one,
    }
    for name, patch in patches.items():
        monkeypatch.setattr(growth, name, patch)

    def with_more(_search: Any, one: Any, *_: Any) -> Any:
        taken.append("more")
        return fit(*one.names, "second" if "first" in one.names else "first")

    monkeypatch.setattr(growth, "with_more", with_more)
    return taken


def test_a_search_that_comes_back_to_a_set_of_effects_ends(steps: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    def alternating(_search: Any, one: Any, *_: Any) -> Any:
        return fit("second") if len(steps) % 2 else fit("first")

    monkeypatch.setattr(growth, "reduced", alternating)
    growth.extended(search_that_never_ends(), fit("first"), [], [])
    assert len(steps) == 2


def test_a_search_in_a_circle_beside_numbers_out_of_tolerance_looks_around_the_nominal_ones(
    steps: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A mode of the base promised most around these, and nothing beside a mass five times its tolerance off."""

    def alternating(_search: Any, one: Any, *_: Any) -> Any:
        return fit("third", "first") if "third" in one.names else fit("second" if len(steps) % 2 else "first")

    monkeypatch.setattr(growth, "reduced", alternating)
    monkeypatch.setattr(growth, "draws_numbers", lambda *_: True)
    monkeypatch.setattr(growth, "from_nominal_numbers", lambda _search, one, _fits: fit(*one.names, "third"))
    found = growth.extended(search_that_never_ends(), fit("first"), [], [])
    assert found.names == {"first", "third"}


@pytest.mark.parametrize(("left", "limited", "expected"), [
    ((60.0, 20.0, 11.0), False, ["first", "1", "2", "3"]),  # of 90 above the floor, then 50, 10
    ((60.0, 20.0, 11.0), True, ["first", "1"]),  # its search is widened instead
    ((60.0, 45.0, 11.0), False, ["first", "1"]),  # 15 of 50: imitations do that
    ((60.0, 39.0, 11.0), False, ["first", "1", "2", "3"]),  # 21 of 50: a gain and a ripple did, before backlash
    ((99.0, 20.0, 19.0), False, ["first", "1", "2"]),  # the first step may be small
])  # fmt: skip
def test_on_a_real_machine_the_search_goes_on_while_steps_remove_most_of_what_is_left(
    left: tuple[float, ...], limited: bool, expected: list[str], steps: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """An oscillator at the end of the arm showed behind friction only, which the first step completed."""

    def with_more(_search: Any, one: Any, *_: Any) -> Any:
        steps.append("more")
        grown = fit(*one.hypothesis, str(len(steps)))
        grown.chi2 = left[len(steps) - 1]
        return grown

    monkeypatch.setattr(growth, "with_more", with_more)
    monkeypatch.setattr(growth, "reduced", lambda _search, one, *_: one)
    ended = SimpleNamespace(widened=lambda _: limited or None)
    monkeypatch.setattr(growth, "at_limits", lambda _: [(ended, "size")])
    search = search_that_never_ends()
    search.torques_decide = True
    assert list(growth.extended(search, fit("first"), [], []).hypothesis) == expected


def test_a_group_that_promises_less_than_a_further_step_must_remove_is_not_fitted(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    found = [addition("mode@tool", 20.0), addition("drag@motor_1", 15.0)]
    assert first_group(monkeypatch, found, further=0.5, torques_decide=True) == [20.0, 15.0]
    with pytest.raises(IndexError):  # nothing was tried: 9 of 89 above the floor
        first_group(monkeypatch, [addition("drag@motor_1", 9.0)], further=0.5, torques_decide=True)


@pytest.mark.parametrize(("share", "expected"), [(0.5, True), (0.9, False)])
def test_candidates_promise_what_they_gain_together(
    share: float, expected: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By linear theory two gain 35 of 90 above the floor, and half of what they must is enough."""
    search = search_with([addition("mode@tool", 20.0), addition("drag@motor_1", 15.0)], monkeypatch)
    assert growth.promises(search, fit(), [], share) is expected


@pytest.mark.parametrize(("left", "expected"), [(True, 1), (False, 0)])
def test_effects_are_corrected_only_while_something_is_left(
    left: bool, expected: int, steps: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    called: list[Any] = []

    def corrected(_search: Any, one: Any, *_: Any) -> Any:
        called.append(one)
        return one

    monkeypatch.setattr(growth, "corrected", corrected)
    monkeypatch.setattr(growth, "reduced", lambda _search, one, *_: one)
    monkeypatch.setattr(growth, "incomplete", lambda *_: not steps or (left and not called))
    found = growth.extended(search_that_never_ends(), fit("first"), [], [])
    assert found.names == {"first", "second"}
    assert len(called) == expected


def test_small_changes_are_regrouped_before_single_effects_are_exchanged(
    steps: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[frozenset[str]] = []

    def exchanged(_search: Any, one: Any, *_: Any) -> Any:
        seen.append(one.names)
        return one

    monkeypatch.setattr(growth, "reduced", lambda _search, one, *_: one)
    monkeypatch.setattr(growth, "regrouped", lambda *_: fit("load"))
    monkeypatch.setattr(growth, "exchanged", exchanged)
    search = search_that_never_ends()
    search.completed = lambda one: one
    assert growth.tidied(search, fit("inertia", "spring"), [], []).names == {"load"}
    assert seen == [frozenset({"load"})]


@pytest.mark.parametrize(("vain", "noise", "kept"), [(True, 0.9, False), (True, 1.0, True), (False, 0.9, True)])
def test_a_step_of_a_resumed_search_removes_as_much_as_an_effect_must_in_the_end(
    monkeypatch: pytest.MonkeyPatch, steps: list[str], vain: bool, noise: float, kept: bool
) -> None:
    """Errors of form were imitated round after round: a search in a looser tie did not end in a quarter of an hour."""
    levels = {1: 1.1, 2: 1.05}
    found = SimpleNamespace(score=lambda _fit: 0.0, threshold=0.0, level=lambda one: levels[len(one.names)])
    monkeypatch.setattr(growth, "compared", lambda *_: found)
    monkeypatch.setattr(growth, "in_vain", lambda *_: vain)
    monkeypatch.setattr(growth, "reduced", lambda _search, one, *_: one)
    search = search_that_never_ends()
    search.left_before = noise
    assert (growth.extended(search, fit("first"), [], []).names > {"first"}) is kept
    assert steps


@pytest.mark.parametrize(
    ("resumed", "torque_noise", "grows"), [(False, 1.0, True), (False, 10.0, False), (True, 10.0, True)]
)
def test_near_an_uncertain_floor_effects_are_added_where_they_show_best(
    monkeypatch: pytest.MonkeyPatch, steps: list[str], resumed: bool, torque_noise: float, grows: bool
) -> None:
    monkeypatch.setattr(growth, "incomplete", lambda *_: False)
    monkeypatch.setattr(growth, "floor_is_uncertain", lambda *_: True)
    monkeypatch.setattr(growth, "in_vain", lambda *_: False)
    monkeypatch.setattr(growth, "reduced", lambda _search, one, *_: one)
    search = search_that_never_ends()
    search.resumed, search.data.torque_noise = resumed, torque_noise
    growth.extended(search, fit("first"), [], [])
    assert bool(steps) is grows


def addition(name: str, gain: float, parameters: int = 1) -> Any:
    candidate = SimpleNamespace(name=name, free=range(parameters))
    one = SimpleNamespace(candidate=candidate, gain=gain, change=np.ones(3))
    one.sized = lambda _size: one
    return one


def search_with(found: list[Any], monkeypatch: pytest.MonkeyPatch) -> Any:
    """A search with some candidates that are independent of each other."""
    search = search_that_never_ends()
    search.surroundings = lambda _fit: SimpleNamespace(
        independent=lambda changes, *_: range(changes.shape[1]), sizes=lambda changes: np.ones(changes.shape[1])
    )
    search.harmonics, search.directions, search.additions = (lambda *_: []), (lambda *_: []), (lambda *_: found)
    monkeypatch.setattr(growth, "simple_first", lambda _search, _fit, additions: additions)
    return search


def first_group(
    monkeypatch: pytest.MonkeyPatch, found: list[Any], *, further: float = 0.0, torques_decide: bool = False
) -> list[float]:
    """Gains of the candidates that are tried together first, of some that are independent of each other."""
    tried: list[Any] = []
    search = search_with(found, monkeypatch)
    known = {"_removed": 0.0, "_least_gain": 0.0, "best_of_each": [], "compared": None, "worth": True}
    for name, value in known.items():
        monkeypatch.setattr(growth, name, lambda *_, value=value: value)
    monkeypatch.setattr(
        growth, "fitted_with", lambda _search, _fit, trials, _fits: tried.append(trials[0]) or fit("first")
    )
    search.torques_decide = torques_decide
    growth.with_more(search, fit(), [], [], further)
    return [one.gain for one in tried[0]]


def test_two_orders_of_one_effect_are_not_added_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """An explanation holds an effect at a place once; its rival orders would share a name, and be removed as one."""
    found = [addition("ripple@motor_1", 9.0), addition("ripple@motor_1", 8.0), addition("drag@motor_1", 5.0)]
    assert first_group(monkeypatch, found) == [9.0, 5.0]


def test_what_gains_less_than_its_parameters_cost_is_not_added_beside_others(monkeypatch: pytest.MonkeyPatch) -> None:
    """Three eccentricities that noise feigned made a group not worth it in which a gain of torques was right."""
    found = [addition("gain@motor_3", 150.0), addition("drag@motor_1", 5.0), addition("ripple@motor_2", 6.5, 3)]
    assert first_group(monkeypatch, found) == [150.0, 5.0]  # ln 10 per parameter


def test_where_a_group_is_not_worth_it_different_candidates_are_tried_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """A lag was not worth it beside an eccentricity, and its twins came before friction, which was the cause."""
    rng = np.random.default_rng(6)
    lag, drag, ripple = rng.normal(size=(3, 400))
    around = Surroundings(-2 * lag - 1.8 * drag, np.zeros((400, 0)), np.zeros(0), np.zeros(0), 1.0)
    changes = {"lag": 2 * lag, "delay": 2 * lag + 0.02 * ripple, "hold": 1.9 * lag, "drag": 1.8 * drag}
    gains = around.gains(np.stack(list(changes.values()), axis=-1))[0]
    found = [addition(name, gain) for name, gain in zip(changes, gains)]
    for one in found:
        one.change = changes[one.candidate.name]
    search = search_with(found, monkeypatch)
    search.surroundings = lambda _fit: around
    tried: list[list[str]] = []

    def fitted(_search: Any, _fit: Any, trials: Any, _fits: Any) -> Any:
        tried.append(["+".join(one.candidate.name for one in trial) for trial in trials])
        return fit(*tried[-1])

    for name, value in (("_removed", 0.0), ("_least_gain", 0.0), ("best_of_each", []), ("compared", None)):
        monkeypatch.setattr(growth, name, lambda *_, value=value: value)
    monkeypatch.setattr(growth, "_independent", lambda *_: [found[0], found[0]])
    monkeypatch.setattr(growth, "fitted_with", fitted)
    monkeypatch.setattr(growth, "worth", lambda _search, _comparison, _before, after, _least: "drag" in after.names)
    assert growth.with_more(search, fit(), [], []).names == {"lag", "drag"}
    assert tried == [["lag+lag"], ["lag", "drag"]]


@pytest.mark.parametrize(
    ("level", "gap", "expected"),
    [(1.01, 2000.0, 4.0 * N), (1.01, 10.0, 0.02 * N), (1.1, 2000.0, 0.06 * N), (1.1, 10.0, 0.0), (1.5, 2000.0, 0.0)],
)
def test_near_noise_candidates_must_promise_what_an_effect_must_gain_there(
    level: float, gap: float, expected: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two axes gained 300 nats at a time below noise, beside a gap of 2000 floors, for as long as there was time."""
    monkeypatch.setattr(growth, "gap_of_laws", lambda *_: gap)
    monkeypatch.setattr(growth, "compared", lambda *_: None)
    monkeypatch.setattr(growth, "more_than_chance", lambda *_: level > 1.05)
    search: Any = SimpleNamespace(data=SimpleNamespace(n_values=N), settings=DiagnosisSettings(), torques_decide=False)
    one: Any = SimpleNamespace(chi2=level * N)
    assert growth._least_gain(search, one) == pytest.approx(expected)


def test_candidates_that_promise_too_little_near_noise_are_not_fitted(monkeypatch: pytest.MonkeyPatch) -> None:
    found = [addition("ripple@motor_1", 30.0), addition("mode@base", 25.0)]
    monkeypatch.setattr(growth, "_least_gain", lambda *_: 100.0)
    tried: list[Any] = []
    monkeypatch.setattr(
        growth, "fitted_with", lambda _search, _fit, trials, _fits: tried.append(trials) or fit("first")
    )
    for name, value in (("_removed", 0.0), ("best_of_each", []), ("compared", None), ("worth", True)):
        monkeypatch.setattr(growth, name, lambda *_, value=value: value)
    assert growth.with_more(search_with(found[:1], monkeypatch), fit(), [], []) is None
    assert not tried
    growth.with_more(search_with(found, monkeypatch), fit(), [], [])  # half of 100 is enough
    assert tried == [[found]]


@pytest.mark.parametrize(("level", "goes_on"), [(2.17, True), (3.9, False)])
def test_the_search_of_a_measured_log_goes_on_after_an_exchange_that_removed_much(
    monkeypatch: pytest.MonkeyPatch, level: float, goes_on: bool
) -> None:
    """Friction that yields took the place of friction that slides at once, beside which nothing further had shown."""
    scores = {1: 0.0, 2: 100.0}
    found = SimpleNamespace(score=lambda one: scores[len(one.names)], threshold=10.0)
    monkeypatch.setattr(growth, "compared", lambda *_: found)
    monkeypatch.setattr(growth, "extended", lambda _search, one, *_, again: fit(*one.names, "ripple") if again else one)
    monkeypatch.setattr(growth, "tidied", lambda _search, one, *_: one)
    search, before, exchanged = search_that_never_ends(), fit("slides"), fit("yields")
    search.premises, search.torques_decide = MEASURED, True
    before.chi2, exchanged.chi2 = 4.1 * search.data.n_values, level * search.data.n_values
    done = growth.resumed(search, before, exchanged, [], [])
    assert ("ripple" in done.names) is goes_on
