"""Elimination of the effects that torques show, and of further ones, by linear theory and by fits."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexros.gap.deadline import Deadline
from flexros.gap.search.elimination import needless, reduce
from flexros.record.premises import MEASURED, SIMULATED, Premises
from tests.gap.search.elimination.named_fits import (
    BIAS,
    COULOMB,
    INERTIA,
    LOAD,
    STIFFNESS,
    VISCOUS,
    Fit,
    N,
    Search,
    plain_rules,
    size_of,
)


@pytest.fixture(autouse=True)
def plain(monkeypatch: pytest.MonkeyPatch) -> None:
    plain_rules(monkeypatch, reduce, needless)


def test_of_two_effects_that_do_much_the_same_the_better_one_stays() -> None:
    base = (COULOMB, VISCOUS, "coulomb_friction@motor_2")
    rest = frozenset({COULOMB, "coulomb_friction@motor_2"})
    search: Any = Search({rest: 2010.0}, {COULOMB: 20.0, VISCOUS: 10.0, "coulomb_friction@motor_2": 500.0}, base)
    fits: list[Any] = []
    assert reduce.reduced(search, Fit(base, 2000.0), fits, 0.2).names == rest  # type: ignore[arg-type]
    assert len(fits) == 1


def test_of_effects_at_other_places_that_seem_needless_the_least_needed_one_goes_first() -> None:
    """A lag of one motor beside a delay of all: without either, the other one is needed."""
    delay, lag = "delay@all", "actuator_lag@motor_1"
    left = {(COULOMB, delay): 2100.0, (COULOMB, lag): 2200.0, (COULOMB,): 3000.0}
    rises = {COULOMB: 900.0, delay: 200.0, lag: 100.0}
    search: Any = Search({frozenset(names): chi2 for names, chi2 in left.items()}, rises, (COULOMB,))
    search.completed = lambda fit: fit
    kept = reduce.one_by_one(search, Fit((COULOMB, delay, lag), 2000.0), [])  # type: ignore[arg-type]
    assert kept.names == {COULOMB, delay}


def test_nothing_is_left_out_where_the_result_would_be_of_no_use() -> None:
    search: Any = Search({frozenset({COULOMB}): 2010.0}, {COULOMB: 900.0, VISCOUS: 10.0}, ())
    begin: Any = Fit((COULOMB, VISCOUS), 2000.0)
    assert reduce.one_by_one(search, begin, [], most=1999.0) is begin
    assert reduce.one_by_one(search, begin, [], most=2001.0).names == {COULOMB}


def test_of_unclear_effects_of_a_servo_the_least_clear_one_goes_first(monkeypatch: pytest.MonkeyPatch) -> None:
    """Inertia and viscous friction have a common factor: without the one that is nearly zero, the other is clear."""

    def sizes(fit: Fit, _: Any) -> list[dict[str, Any]]:
        both = {INERTIA, VISCOUS} <= fit.names
        unclear = {INERTIA: size_of(-0.39, 0.49), VISCOUS: size_of(-0.03, 4.3)}
        return [{"size": unclear[one] if both and one in unclear else size_of(1.0, 0.1)} for one in fit.kept]

    monkeypatch.setattr(needless, "parameters_of", sizes)
    base, rest = (INERTIA, VISCOUS, "coulomb_friction@motor_2"), frozenset({INERTIA, "coulomb_friction@motor_2"})
    search: Any = Search({rest: 2001.0}, {INERTIA: 1.0, VISCOUS: 2.0, "coulomb_friction@motor_2": 500.0}, base)
    search.data.record.command = np.zeros((N, 2))
    assert reduce.reduced(search, Fit(base, 2000.0), [], 0.2).names == rest  # type: ignore[arg-type]


def test_a_further_effect_that_removes_little_is_left_out() -> None:
    every = Fit((COULOMB, BIAS), 2000.0)
    search: Any = Search({frozenset({COULOMB}): 2050.0}, {COULOMB: 900.0, BIAS: 50.0}, (COULOMB,))
    assert reduce.reduced(search, every, [], 0.2).names == {COULOMB}  # type: ignore[arg-type]


def test_of_two_needless_effects_at_a_motor_the_one_that_torques_show_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    """Beside friction by the load Coulomb friction is not clear; the part by the load removes little all the same."""

    def sizes(fit: Fit, _: Any) -> list[dict[str, Any]]:
        return [{"size": size_of(1.0, 1.0 if one == COULOMB and LOAD in fit.names else 0.1)} for one in fit.kept]

    monkeypatch.setattr(needless, "parameters_of", sizes)
    base = (COULOMB, "coulomb_friction@motor_2")
    chi2 = {frozenset(base): 2100.0, frozenset({LOAD, base[1]}): 2001.0}
    search: Any = Search(chi2, {COULOMB: 1.0, LOAD: 100.0, base[1]: 900.0}, base)
    found = reduce.reduced(search, Fit((*base, LOAD), 2000.0), [], 0.2)  # type: ignore[arg-type]
    assert found.names == set(base)


@pytest.mark.parametrize("premises", [SIMULATED, MEASURED], ids=["simulated", "measured"])
@pytest.mark.parametrize("chi2", [1000.0 - 30.0, 1000.0 + 30.0], ids=["below the floor", "above the floor"])
def test_an_effect_that_gains_nothing_is_left_out_wherever_the_floor_is(chi2: float, premises: Premises) -> None:
    """Half of all logs whose causes are found end below it, by chance."""
    search: Any = Search({frozenset({COULOMB}): chi2 + 0.1}, {COULOMB: 900.0, BIAS: 0.1}, ())
    search.torques_decide, search.premises = False, premises
    assert reduce.reduced(search, Fit((COULOMB, BIAS), chi2), [], 0.2).names == {COULOMB}  # type: ignore[arg-type]


@pytest.mark.parametrize(("viscous", "expected"), [
    (1.0, {INERTIA}),
    (30.0, {INERTIA, VISCOUS}),
], ids=["all needless", "one is needed beside the others"])  # fmt: skip
def test_several_effects_that_gain_nothing_together_are_left_out_with_one_fit(
    viscous: float, expected: set[str]
) -> None:
    """A sum that gains more than its parameters cost is shortened by the effect that gains most."""
    several = (COULOMB, BIAS, LOAD)
    search: Any = Search({frozenset(expected): 1002.0}, dict.fromkeys((*several, VISCOUS), 1.0) | {INERTIA: 900.0}, ())
    search.estimated[VISCOUS] = viscous
    search.torques_decide, search.premises = False, MEASURED
    if viscous > 1:
        search.chi2[frozenset({INERTIA})] = 1400.0
    fits: list[Any] = []
    found = reduce.reduced(search, Fit((*several, VISCOUS, INERTIA), 1000.0), fits, 0.2)  # type: ignore[arg-type]
    assert found.names == expected
    assert [fit.names for fit in fits][:1] == [expected]


def test_of_several_effects_that_a_fit_needs_one_after_the_other_is_left_out() -> None:
    """Linear theory does not see what two of them do together."""
    several = (COULOMB, BIAS, LOAD)
    search: Any = Search({}, dict.fromkeys(several, 1.0) | {INERTIA: 900.0}, ())
    search.torques_decide, search.premises = False, MEASURED
    search.chi2 = {frozenset({INERTIA}): 1500.0, frozenset({INERTIA, BIAS, LOAD}): 1001.0}
    search.chi2 |= {frozenset({INERTIA, COULOMB, one}): 1002.0 for one in (BIAS, LOAD)}
    search.chi2 |= {frozenset({INERTIA, one}): 1500.0 for one in (BIAS, LOAD)}
    found = reduce.reduced(search, Fit((*several, INERTIA), 1000.0), [], 0.2)  # type: ignore[arg-type]
    assert found.names == {INERTIA, BIAS, LOAD}


@pytest.mark.parametrize(("premises", "expected"), [
    (SIMULATED, {COULOMB, INERTIA, BIAS}), (MEASURED, {COULOMB}),
], ids=["simulated", "measured"])  # fmt: skip
def test_several_effects_left_out_of_a_simulated_log_remove_less_together_than_one_must(
    premises: Premises, expected: set[str]
) -> None:
    """Of ten effects beside one that no candidate explains, four true ones went one after the other."""
    every = (COULOMB, INERTIA, BIAS, LOAD)
    chi2 = {frozenset(every[:3]): 2300.0, frozenset(every[:2]): 2690.0, frozenset(every[:1]): 3200.0}
    search: Any = Search(chi2, {COULOMB: 9000.0, INERTIA: 390.0, BIAS: 320.0, LOAD: 300.0}, ())
    search.torques_decide, search.premises = False, premises
    search.parallel = lambda _, function, items, **__: [function(items[0])]
    assert reduce.reduced(search, Fit(every, 2000.0), [], 0.3).names == expected  # type: ignore[arg-type]


@pytest.mark.parametrize(("strained", "premises", "expected"), [
    (True, SIMULATED, {COULOMB}),
    (False, SIMULATED, {COULOMB, BIAS}),
    (True, MEASURED, {COULOMB, BIAS}),
])  # fmt: skip
def test_beside_numbers_out_of_tolerance_effects_that_seem_needed_are_tried_as_well(
    strained: bool, premises: Premises, expected: set[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without an imitation the numbers go back to their tolerances, which linear theory does not see."""
    found = SimpleNamespace(threshold=6.0, beyond_tolerance=lambda _: strained)
    monkeypatch.setattr(reduce, "compared", lambda *_: found)
    search: Any = Search({frozenset({COULOMB}): 990.0, frozenset({BIAS}): 5000.0}, {COULOMB: 9000.0, BIAS: 900.0}, ())
    search.torques_decide, search.premises = False, premises
    every = Fit((COULOMB, BIAS), 1000.0)
    assert reduce.reduced(search, every, [], 0.2).names == expected  # type: ignore[arg-type]


def test_beside_numbers_out_of_tolerance_every_mode_is_tried(monkeypatch: pytest.MonkeyPatch) -> None:
    """By linear theory it is needed most; but springs and inertias far from their values take its place."""
    found = SimpleNamespace(threshold=6.0, beyond_tolerance=lambda _: True)
    monkeypatch.setattr(reduce, "compared", lambda *_: found)
    needed, mode = (COULOMB, VISCOUS, BIAS, INERTIA), "extra_mode@base"
    every = (*needed, mode)
    chi2 = {frozenset({*every} - {one}): 5000.0 for one in needed} | {frozenset(needed): 990.0}
    chi2 |= {frozenset({*needed} - {one}): 5000.0 for one in needed}
    search: Any = Search(chi2, {**dict.fromkeys(needed, 9000.0), mode: 9e4}, ())
    search.torques_decide, search.premises = False, SIMULATED
    assert reduce.reduced(search, Fit(every, 1000.0), [], 0.2).names == {*needed}  # type: ignore[arg-type]


def test_without_time_all_that_seems_needless_is_left_out_at_once() -> None:
    base = (COULOMB, VISCOUS, "coulomb_friction@motor_2")
    search: Any = Search(
        {frozenset({"coulomb_friction@motor_2"}): 2400.0},
        {COULOMB: 20.0, VISCOUS: 10.0, "coulomb_friction@motor_2": 500.0},
        base,
    )
    search.deadline = over()
    found = reduce.reduced(search, Fit(base, 2000.0), [], 0.2)  # type: ignore[arg-type]
    assert found.names == {"coulomb_friction@motor_2"}


def test_behind_springs_all_that_seems_needless_is_left_out_at_once() -> None:
    """See test_flexible_drive.py: one friction term would stand for an error of the spring."""
    search: Any = Search({frozenset({BIAS}): 2400.0}, {COULOMB: 20.0, VISCOUS: 10.0, BIAS: 500.0}, (COULOMB, VISCOUS))
    search.null.model.robot.n_coordinates = 4
    found = reduce.reduced(search, Fit((COULOMB, VISCOUS, BIAS), 2000.0), [], 0.2)  # type: ignore[arg-type]
    assert found.names == {BIAS}


def test_a_needed_effect_does_not_keep_a_needless_one_that_was_left_out_with_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Without the error of a spring, numbers of the model go far out of tolerance to do its work."""
    without = {frozenset(names): 2000.0 for names in ((COULOMB,), (COULOMB, STIFFNESS), (COULOMB, BIAS))}
    search: Any = Search(without, {COULOMB: 900.0, STIFFNESS: 20.0, BIAS: 10.0}, (COULOMB,))
    search.null.model.robot.n_coordinates = 4
    monkeypatch.setattr(reduce, "strains", lambda _, __, fit, rest: STIFFNESS in fit.names - rest.names)
    found = reduce.reduced(search, Fit((COULOMB, STIFFNESS, BIAS), 2000.0), [], 0.2)  # type: ignore[arg-type]
    assert found.names == {COULOMB, STIFFNESS}


def test_a_further_effect_without_which_a_fit_leaves_much_stays_whatever_linear_theory_says() -> None:
    without = {frozenset({COULOMB}): 2e5, frozenset({COULOMB, STIFFNESS}): 2000.0, frozenset({COULOMB, BIAS}): 2e5}
    search: Any = Search(without, {COULOMB: 900.0, STIFFNESS: 20.0, BIAS: 10.0}, (COULOMB,))
    search.null.model.robot.n_coordinates = 4
    found = reduce.reduced(search, Fit((COULOMB, STIFFNESS, BIAS), 2000.0), [], 0.2)  # type: ignore[arg-type]
    assert found.names == {COULOMB, STIFFNESS}


def test_effects_within_the_floor_are_left_out_one_by_one_after_a_fit(monkeypatch: pytest.MonkeyPatch) -> None:
    """Linear theory takes two for needless; without the second one far more is left, and it stays."""
    chi2 = {
        frozenset({COULOMB, STIFFNESS}): 110.0,
        frozenset({COULOMB, BIAS}): 900.0,
        frozenset({COULOMB}): 950.0,
    }
    search: Any = Search(chi2, {COULOMB: 900.0, STIFFNESS: 12.0, BIAS: 10.0}, (COULOMB,))
    search.completed = lambda fit: fit
    search.null.model.robot.n_coordinates = 4
    fits: list[Any] = []
    found = reduce.one_by_one(search, Fit((COULOMB, STIFFNESS, BIAS), 100.0), fits)  # type: ignore[arg-type]
    assert found.names == {COULOMB, STIFFNESS}
    assert [fit.names for fit in fits] == [{COULOMB, STIFFNESS}, {COULOMB}, {COULOMB}]


@pytest.mark.parametrize(
    ("quick", "fall", "finished", "kept"),
    [(110.0, 0.0, None, False), (110.0, 50.0, 109.0, False), (900.0, 0.0, 110.0, False), (900.0, 0.0, 890.0, True)],
    ids=["little is left", "no minimum yet", "little in the end", "much in the end"],
)
def test_a_quick_fit_decides_where_one_to_the_end_cannot_decide_otherwise(
    quick: float, fall: float, finished: float | None, kept: bool
) -> None:
    """The sum of squares falls further in a fit to the end: little stays little, and much may become little."""
    search: Any = Search({frozenset({COULOMB}): quick}, {COULOMB: 900.0, BIAS: 10.0}, (COULOMB,))
    search.null.model.robot.n_coordinates = 4
    search.fall, ended = fall, []

    def completed(fit: Fit) -> Fit:
        assert finished is not None
        ended.append(fit)
        return Fit(fit.kept, finished)

    search.completed = completed
    found = reduce.one_by_one(search, Fit((COULOMB, BIAS), 100.0), [])  # type: ignore[arg-type]
    assert found.names == ({COULOMB, BIAS} if kept else {COULOMB})
    assert len(ended) == (finished is not None)
    assert kept or found.chi2 == (finished or quick)


def over() -> Deadline:
    """Return a deadline that is over."""
    return Deadline(interrupted=lambda: True)
