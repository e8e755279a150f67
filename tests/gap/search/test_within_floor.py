"""Several effects of a measured log that hide each other, within its floor and above."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from flexros.gap.search import within_floor, worth
from flexros.gap.settings import DiagnosisSettings
from flexros.record.premises import MEASURED

LEVELS = {"base": 1.9, "base+one": 1.2, "base+one+two": 0.81, "base+one+two+three": 0.809}
NOISE = 0.8


def fit(*names: str, level: float) -> Any:
    return SimpleNamespace(names=frozenset(names), hypothesis=names, level=level, chi2=level)


def search(is_rigid: bool = False) -> Any:
    return SimpleNamespace(
        null=SimpleNamespace(model=SimpleNamespace(robot=SimpleNamespace(is_rigid=is_rigid))),
        settings=DiagnosisSettings(),
        premises=MEASURED,
        deadline=SimpleNamespace(stops=lambda: False),
        completed=lambda one: one,
    )


@pytest.fixture
def levels(monkeypatch: pytest.MonkeyPatch) -> dict[str, float]:
    """Levels by the effects of a fit, in the order in which they are added."""
    known, order = dict(LEVELS), ("base", "one", "two", "three")
    comparison = SimpleNamespace(
        level=lambda one: one.level, beyond_noise=lambda level: max(level - NOISE, 0.0) / (1 - NOISE)
    )
    for module in (within_floor, worth):
        monkeypatch.setattr(module, "compared", lambda *_: comparison)

    def with_more(_search: Any, one: Any, *_: Any, **_named: Any) -> Any:
        names = order[: len(one.hypothesis) + 1]
        level = known.get("+".join(names))
        return None if level is None else fit(*names, level=level)

    monkeypatch.setattr(within_floor, "with_more", with_more)
    monkeypatch.setattr(within_floor, "best_richer", lambda *_: None)
    monkeypatch.setattr(within_floor, "one_by_one", lambda _search, one, _fits: one)
    monkeypatch.setattr(within_floor, "with_gains", lambda _search, one, *_: one)
    monkeypatch.setattr(within_floor, "first_parameters", lambda one: dict.fromkeys(one.names, 1.0))
    return known


@pytest.mark.parametrize(("size", "found"), [(0.55, {"base", "one", "two"}), (0.45, {"base"}), (-0.9, {"base"})])
def test_effects_beside_which_others_would_have_quite_another_size_are_none(
    levels: dict[str, float], size: float, found: set[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def sizes(one: Any) -> dict[str, float]:
        return {name: size if name == "base" and len(one.names) > 1 else 1.0 for name in one.names}

    monkeypatch.setattr(within_floor, "first_parameters", sizes)
    begin = fit("base", level=levels["base"])
    assert within_floor.grown_within_floor(search(is_rigid=True), begin, [], []).names == found


def test_behind_springs_gains_take_the_place_of_what_stood_for_them(
    levels: dict[str, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    """They show beside the effects that were added; the search goes on from them."""
    monkeypatch.setattr(within_floor, "with_gains", lambda _search, one, _fits, before: fit("gain", level=1.0))
    begin = fit("base", level=levels["base"])
    fits: list[Any] = []
    assert within_floor.grown_within_floor(search(), begin, [], fits).names == {"gain"}
    assert [one.names for one in fits][:2] == [{"base"}, {"gain"}]
    assert within_floor.grown_within_floor(search(is_rigid=True), begin, [], []).names == {"base", "one", "two"}


def test_what_does_not_leave_little_is_a_fit_that_the_held_out_log_may_be_for(levels: dict[str, float]) -> None:
    levels["base+one"] = 0.95 * levels["base"]
    fits: list[Any] = []
    found = within_floor.grown_within_floor(search(is_rigid=True), fit("base", level=levels["base"]), [], fits)
    assert found.names == {"base"}
    assert [one.names for one in fits] == [{"base", "one"}]


def test_effects_that_leave_little_together_are_kept(levels: dict[str, float]) -> None:
    """The first one alone leaves more than half; the third one removes hardly anything."""
    begin = fit("base", level=levels["base"])
    fits: list[Any] = []
    found = within_floor.grown_within_floor(search(), begin, [], fits)
    assert found.names == {"base", "one", "two"}
    assert begin in fits
    assert found in fits


@pytest.mark.parametrize(("level", "found"), [(1.4, {"richer", "one"}), (1.899, {"base", "one", "two"})])
def test_a_richer_law_that_leaves_less_comes_before_further_effects(
    levels: dict[str, float], level: float, found: set[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    levels["richer+one"] = 0.81
    order = {"base": ("base", "one", "two"), "richer": ("richer", "one")}

    def with_more(_search: Any, one: Any, *_: Any, **_named: Any) -> Any:
        names = order[one.hypothesis[0]][: len(one.hypothesis) + 1]
        known = levels.get("+".join(names))
        return None if known is None or len(names) == len(one.hypothesis) else fit(*names, level=known)

    monkeypatch.setattr(within_floor, "with_more", with_more)
    begin, richer = fit("base", level=levels["base"]), fit("richer", level=level)
    assert within_floor.grown_within_floor(search(), begin, [], [], richer).names == found


def test_effects_that_leave_much_are_none(levels: dict[str, float]) -> None:
    levels |= {"base+one": 1.45, "base+one+two": 1.3}
    begin = fit("base", level=levels["base"])
    assert within_floor.grown_within_floor(search(), begin, [], []) is begin


def test_where_hardly_more_than_noise_is_left_nothing_is_tried(levels: dict[str, float]) -> None:
    """What an effect must take at least, a 25th of the tolerance, is not there."""
    levels |= {"base+one": 0.8001, "base+one+two": 0.80005}
    begin = fit("base", level=NOISE + 0.039 * (1 - NOISE))
    assert within_floor.grown_within_floor(search(), begin, [], []) is begin
    more = fit("base", level=NOISE + 0.041 * (1 - NOISE))
    assert within_floor.grown_within_floor(search(), more, [], []).names == {"base", "one", "two"}


def test_above_the_floors_of_an_explanation_nothing_is_tried(levels: dict[str, float]) -> None:
    begin = fit("base", level=2.1)
    assert within_floor.grown_within_floor(search(), begin, [], []) is begin


@pytest.fixture
def above(levels: dict[str, float]) -> dict[str, float]:
    """The first further effect alone removes a twentieth of what is above the floor, both together most of it."""
    levels.clear()
    levels |= {"base": 21.0, "base+one": 20.0, "base+one+two": 1.8}
    return levels


def test_effects_above_the_floor_that_lead_there_together_are_kept(above: dict[str, float]) -> None:
    begin = fit("base", level=above["base"])
    fits: list[Any] = []
    assert within_floor.grown_to_floor(search(), begin, [], fits).names == {"base", "one", "two"}
    assert fits


def test_above_the_floor_of_an_arm_without_springs_nothing_is_tried(above: dict[str, float]) -> None:
    begin = fit("base", level=above["base"])
    assert within_floor.grown_to_floor(search(is_rigid=True), begin, [], []) is begin


@pytest.mark.parametrize(("first", "last"), [(20.0, 2.1), (20.5, 1.8)])
def test_effects_that_do_not_lead_to_the_floor_or_first_remove_nothing_are_none(
    above: dict[str, float], first: float, last: float
) -> None:
    above |= {"base+one": first, "base+one+two": last}
    begin = fit("base", level=above["base"])
    assert within_floor.grown_to_floor(search(), begin, [], []) is begin


def test_steps_that_remove_less_and_less_above_the_floor_end(above: dict[str, float]) -> None:
    """What imitates something unknown does so; without the third step, its effects do not lead to the floor."""
    above |= {"base+one": 13.0, "base+one+two": 9.0, "base+one+two+three": 1.5}
    begin = fit("base", level=above["base"])
    assert within_floor.grown_to_floor(search(), begin, [], []) is begin
    above |= {"base+one+two": 7.0}
    assert within_floor.grown_to_floor(search(), begin, [], []).names == {"base", "one", "two", "three"}


def test_effects_that_remove_little_above_the_floor_are_none(above: dict[str, float]) -> None:
    above |= {"base": 2.5, "base+one": 2.4, "base+one+two": 1.4}
    begin = fit("base", level=above["base"])
    assert within_floor.grown_to_floor(search(), begin, [], []) is begin


@pytest.mark.parametrize(("without", "found"), [(1.9, {"one", "two"}), (6.0, {"base", "one", "two"})])
def test_an_effect_that_stood_for_those_that_are_there_now_is_left_out_unless_it_is_worth_it(
    above: dict[str, float], without: float, found: set[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def sizes(one: Any) -> dict[str, float]:
        return {name: 0.4 if name == "base" and len(one.names) > 1 else 1.0 for name in one.names}

    monkeypatch.setattr(within_floor, "first_parameters", sizes)
    monkeypatch.setattr(within_floor, "worth", lambda _search, _comparison, rest, *_: rest.level > 3.0)
    trial = search()
    trial.without = lambda _, name: fit("one", "two", level=without)
    assert within_floor.grown_to_floor(trial, fit("base", level=above["base"]), [], []).names == found


def test_within_the_floor_nothing_is_tried_as_above_it(levels: dict[str, float]) -> None:
    begin = fit("base", level=levels["base"])
    assert within_floor.grown_to_floor(search(), begin, [], []) is begin


@pytest.mark.parametrize(("shown", "found"), [(True, {"ripple", "base_tilt@base"}), (False, {"ripple"})])
def test_a_slant_that_torques_show_is_added_beside_what_was_found(
    shown: bool, found: set[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Beside a ripple and friction at low speed the regression of the torques had not shown it."""
    slant, fits = SimpleNamespace(name="base_tilt@base"), []
    chosen, around = fit("ripple", level=2.5), search(is_rigid=True)
    around.slants, around.surroundings = lambda: (slant,), lambda _: None
    around.directions = lambda candidates, _fit: candidates
    around.additions = lambda directions, *_: directions
    around.together = lambda one, additions: fit(*one.names, *(each.name for each in additions), level=2.4)
    monkeypatch.setattr(within_floor, "turned_in_torques", lambda *_: shown)
    monkeypatch.setattr(within_floor, "compared", lambda *_: None)
    monkeypatch.setattr(within_floor, "worth", lambda *_: True)
    assert within_floor.with_slant(around, chosen, fits).names == found
    assert len(fits) == 1
    around.slants = lambda: ()
    assert within_floor.with_slant(around, chosen, []) is chosen
