"""Exchange of rich laws for two effects whose gains add up."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexros.effects import effects
from flexros.gap.candidates.candidate import Candidate
from flexros.gap.search import exchange
from flexros.gap.search.exchange import (
    _compared,
    _divisions,
    _replacements,
    _stopped_early,
    _was_in_vain,
    exchanged,
    filters_for_delay,
    one_delay,
)
from flexros.gap.settings import DiagnosisSettings
from flexros.record.premises import MEASURED, SIMULATED
from tests.gap.diagnosis_logs import candidates_of


class Rest:
    """What is left without a law: the gains of two of three candidates add up."""

    def independent(self, changes: Any, most: int, kept: float) -> list[int]:
        return [0, 2][: min(most, changes.shape[1])]

    def sizes(self, changes: Any) -> Any:
        return np.full(changes.shape[1], 2.0)


@pytest.mark.parametrize(("name", "expected"), [
    ("presliding_friction@motor_1", ["hysteresis@motor_1", "torque_bias@motor_1"]),
    ("coulomb_friction@motor_1", []),
])  # fmt: skip
def test_a_rich_law_is_divided_into_two_effects(name: str, expected: list[str]) -> None:
    def addition(name: str) -> Any:
        one = SimpleNamespace(candidate=SimpleNamespace(name=name), change=np.ones(4))
        one.sized = lambda size: SimpleNamespace(candidate=one.candidate, size=size)
        return one

    names = ("hysteresis@motor_1", "damping_error@body_1.rz", "torque_bias@motor_1")
    search: Any = SimpleNamespace(
        settings=DiagnosisSettings(),
        premises=SIMULATED,
        additions=lambda *_: [addition(each) for each in names],
        surroundings=lambda _: None,
        removals=lambda *_: [Rest()],
    )
    found = _divisions(search, SimpleNamespace(hypothesis=(candidates_of()[name],)), [])
    assert [name for name, _ in found] == [name] * bool(expected)
    assert [one.candidate.name for _, group in found for one in group] == expected
    assert all(one.size == 2.0 for _, group in found for one in group)


@pytest.mark.parametrize(("name", "expected"), [
    ("motor_inertia_error@motor_1", {"motor_inertia_error@motor_1": ["torque_gain_error@motor_1"]}),
    ("torque_bias@motor_1", {"torque_bias@motor_1": ["encoder_offset@motor_1"]}),
    ("coulomb_friction@motor_1", {}),
])  # fmt: skip
def test_effects_that_torques_show_compete_with_what_looks_alike_in_the_torques(
    name: str, expected: dict[str, list[str]]
) -> None:
    """A torque constant that is too large looks like an inertia that is too small, a turned weight like a constant."""
    every = {**candidates_of(), "encoder_offset@motor_1": Candidate(effects()["encoder_offset"], "motor_1", ())}
    names = ("torque_gain_error@motor_1", "torque_bias@motor_1", "encoder_offset@motor_1", "stiffness_error@body_1.rz")
    directions: Any = [SimpleNamespace(candidate=every[one]) for one in names]
    search: Any = SimpleNamespace(
        settings=DiagnosisSettings(),
        shown_by_torques=lambda fit: frozenset({name}),
        additions=lambda competing, *_: [SimpleNamespace(candidate=one.candidate, gain=9.0) for one in competing],
        surroundings=lambda _: None,
        removals=lambda *_: [SimpleNamespace(least=20.0)],
    )
    fit: Any = SimpleNamespace(hypothesis=(every[name],), chi2=10.0)
    found = {one.name: [each.candidate.name for each in more] for one, more in _replacements(search, fit, directions)}
    assert found == expected


def exchanges(
    name: str,
    *gains: float,
    lost: float = 90.0,
    harmonics: tuple[str, ...] = (),
    names: tuple[str, ...] = ("torque_bias@motor_1", "torque_gain_error@motor_1", "stiffness_error@body_1.rz"),
) -> list[str]:
    """Candidates that are fitted in place of an effect whose fit leaves 10, by their predicted gains."""
    every = {**candidates_of(), **{one: harmonic(one) for one in (name, *harmonics) if one not in candidates_of()}}
    found = dict(zip((*names[: len(gains) - len(harmonics)], *harmonics), gains, strict=True))

    def directions(candidates: Any, _: Any = None) -> Any:
        return [SimpleNamespace(candidate=one) for one in candidates]

    search: Any = SimpleNamespace(
        settings=DiagnosisSettings(),
        shown_by_torques=lambda fit: frozenset(),
        additions=lambda competing, *_: [
            SimpleNamespace(candidate=one.candidate, gain=found[one.candidate.name]) for one in competing
        ],
        directions=directions,
        harmonics_in_place=lambda *_: [every[one] for one in harmonics],
        surroundings=lambda _: None,
        removals=lambda *_: [SimpleNamespace(least=10.0 + lost)],
    )
    fit: Any = SimpleNamespace(hypothesis=(every[name],), chi2=10.0)
    competing = directions([every[one] for one in found if one not in harmonics])
    ((_, additions),) = _replacements(search, fit, competing)
    return [one.candidate.name for one in additions]


@pytest.mark.parametrize(
    ("name", "gain", "expected"),
    [
        ("hysteresis@motor_1", 500.0, ["torque_bias@motor_1"]),
        ("hysteresis@motor_1", 400.0, []),
        ("motor_inertia_error@motor_1", 500.0, []),
    ],
    ids=["most is regained", "little is regained", "no rich law"],
)
def test_the_best_simple_candidate_is_fitted_in_place_of_a_rich_law_though_linear_theory_sees_it_far_away(
    name: str, gain: float, expected: list[str]
) -> None:
    assert exchanges(name, gain, 0.95 * gain, lost=900.0) == expected


@pytest.mark.parametrize("left", [False, True])
def test_a_law_that_contains_an_effect_is_fitted_in_its_place_where_something_is_left(
    left: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("flexros.gap.search.exchange.compared", lambda *_: None)
    monkeypatch.setattr("flexros.gap.search.exchange.incomplete", lambda *_: left)
    found = exchanges(
        "coulomb_friction@motor_1", 80.0, 80.0, names=("presliding_friction@motor_1", "torque_bias@motor_1")
    )
    assert found == ["presliding_friction@motor_1"] * left + ["torque_bias@motor_1"]


def harmonic(name: str) -> Candidate:
    effect, _, location = name.partition("@")
    return Candidate(effects()[effect], location, ())


def test_only_candidates_that_may_come_near_an_explanation_are_fitted_in_place_of_its_effects() -> None:
    """One regains less than half of what is lost; of a large loss nine tenths are far too little."""
    assert exchanges("coulomb_friction@motor_1", 80.0, 40.0) == ["torque_bias@motor_1"]
    assert exchanges("coulomb_friction@motor_1", 8999.0, 8000.0, lost=9000.0) == ["torque_bias@motor_1"]


def test_the_other_harmonics_of_its_order_compete_with_a_harmonic() -> None:
    error = "transmission_error@motor_1"
    assert exchanges("torque_ripple@motor_1", 60.0, 80.0, harmonics=(error,)) == ["torque_bias@motor_1", error]
    assert exchanges("coulomb_friction@motor_1", 60.0) == ["torque_bias@motor_1"]


@pytest.mark.parametrize("vain", [False, True])
def test_a_search_in_vain_carries_no_fit_near_it_to_its_end(vain: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """It ends with nothing, and a difference of a nat decides nothing there."""
    delay, lag = (
        SimpleNamespace(names=frozenset({name}), hypothesis=(name, "load"), chi2=100.0) for name in ("delay", "lag")
    )
    comparison = SimpleNamespace(ranked=lambda fits: [delay], fits=[delay, lag], score=lambda _fit: 0.0)
    for room, value in {
        "in_vain": lambda *_: vain,
        "_replacements": lambda *_: [],
        "_compared": lambda *_: (comparison, [delay, lag]),
        "compared": lambda *_: comparison,
        "best_of_each": lambda fits: fits,
        "simplest": lambda search, comparison, fit, fits: fit,
        "_stopped_early": lambda search, fit, other: other is lag,
    }.items():
        monkeypatch.setattr(exchange, room, value)
    carried: list[Any] = []
    search: Any = SimpleNamespace(
        settings=DiagnosisSettings(),
        deadline=SimpleNamespace(stops=lambda: False),
        to_compare=lambda fit: fit,
        parallel=lambda step, work, fits: carried.extend(fits) or list(map(work, fits)),
    )
    assert exchanged(search, delay, [], []) is delay
    assert carried == ([] if vain else [lag])


@pytest.mark.parametrize(
    ("premises", "chi2", "fewer", "score", "taken"),
    [
        (SIMULATED, 101.0, 2, 120.0, True),
        (SIMULATED, 101.0, 2, 99.0, False),
        (SIMULATED, 99.9, 0, 99.0, True),
        (MEASURED, 101.0, 2, 120.0, True),
        (MEASURED, 99.95, 0, 120.0, False),
        (MEASURED, 99.8, 0, 120.0, True),
    ],
)
def test_an_effect_with_fewer_parameters_that_does_as_much_takes_the_place_of_another(
    premises: Any, chi2: float, fewer: int, score: float, taken: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An extra mode leaves a little less than the error of a spring that it imitates, with two parameters more.

    With as many parameters an effect of a measured log must leave clearly less.
    """

    def with_effect(name: str, number: int, chi2: float, n_effect: int) -> Any:
        predictor = SimpleNamespace(n_effect=n_effect)
        names, both = frozenset({name, "lag"}), (1, number)
        return SimpleNamespace(names=names, hypothesis=both, chi2=chi2, converged=True, predictor=predictor)

    mode, spring = with_effect("mode", 2, 100.0, 4), with_effect("spring", 3, chi2, 4 - fewer)
    comparison = SimpleNamespace(
        ranked=lambda fits: sorted(fits, key=lambda fit: fit is mode),
        score=lambda fit: score if fit is spring else 100.0,
    )
    monkeypatch.setattr(exchange, "_replacements", lambda *_: [])
    monkeypatch.setattr(exchange, "_compared", lambda *_: (comparison, [mode, spring]))
    monkeypatch.setattr(exchange, "simplest", lambda search, comparison, fit, fits: fit)
    monkeypatch.setattr(exchange, "_stopped_early", lambda *_: False)
    search: Any = SimpleNamespace(
        settings=DiagnosisSettings(),
        premises=premises,
        deadline=SimpleNamespace(stops=lambda: False),
        resumed=False,
        completed=lambda fit: fit,
    )
    assert exchanged(search, mode, [], []) is (spring if taken else mode)


@pytest.mark.parametrize(
    ("name", "rise", "converged", "early"),
    [
        ("actuator_lag@motor_1", 30.0, False, True),
        ("actuator_lag@motor_1", 30.0, True, False),
        ("actuator_lag@motor_1", 3000.0, False, False),
        ("coulomb_friction@motor_1", 30.0, False, False),
    ],
)
def test_a_plain_effect_that_comes_near_another_is_carried_to_its_end(
    name: str, rise: float, converged: bool, early: bool
) -> None:
    """Else a lag that was begun seems to be clearly worse than the delay that was finished."""
    search: Any = SimpleNamespace(settings=DiagnosisSettings(), data=SimpleNamespace(n_values=10_000))
    delay, other = (
        Candidate(effects()[one.partition("@")[0]], one.partition("@")[2], ()) for one in ("delay@motor_1", name)
    )
    fit: Any = SimpleNamespace(hypothesis=(delay,), chi2=10_000.0)
    exchanged: Any = SimpleNamespace(hypothesis=(other,), chi2=10_000.0 + rise, converged=converged)
    assert _stopped_early(search, fit, exchanged) is early


@pytest.mark.parametrize(
    ("premises", "then", "now", "left", "again"),
    [
        (MEASURED, 100.0, 95.0, 130.0, False),
        (MEASURED, 100.0, 70.0, 130.0, True),
        (MEASURED, 100.0, 95.0, 90.0, True),
        (SIMULATED, 100.0, 95.0, 130.0, True),
    ],
    ids=["worse before", "worse when more was left", "better before", "simulated log"],
)
def test_an_exchange_is_not_tried_again_where_it_was_worse_and_about_as_much_is_left(
    premises: Any, then: float, now: float, left: float, again: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    friction: Any = SimpleNamespace(name="coulomb")
    bristles: Any = SimpleNamespace(candidate=SimpleNamespace(name="presliding"))
    fit: Any = SimpleNamespace(names=frozenset({"coulomb"}), hypothesis=(friction,), chi2=then)
    other = SimpleNamespace(names=frozenset({"presliding"}), hypothesis=(bristles.candidate,), chi2=left)
    monkeypatch.setattr(exchange, "compared", lambda *_: SimpleNamespace(fits=[fit, other]))
    monkeypatch.setattr(exchange, "best_of_each", lambda fits: fits)
    search: Any = SimpleNamespace(
        premises=premises,
        in_vain={},
        plants=lambda *_: {},
        parallel=lambda *_: [other],
        visible=lambda fits: fits,
    )
    _compared(search, fit, [(friction, bristles)], [])
    later: Any = SimpleNamespace(chi2=now)
    assert _was_in_vain(search, later, friction, bristles) is not again


LAGS = ("servo_command_lag@motor_1", "servo_command_lag@motor_2")
BRAKES = ("viscous_friction@motor_1", "viscous_friction@motor_2")


def fit_of(names: tuple[str, ...], *begin: float) -> Any:
    """A fit of named effects of sizes from 0.01 on, with what those of them begin with that were put in place."""
    every = [
        SimpleNamespace(name=one, effect=effects()[one.partition("@")[0]], location=one.partition("@")[2])
        for one in names
    ]
    tolerance = SimpleNamespace(names=("motor_1.inertia",))
    stiffness = {f"motor_{k}.servo_stiffness": SimpleNamespace(value=2.0) for k in (1, 2)}
    predictor = SimpleNamespace(
        tolerance=tolerance,
        values=lambda _: [{"size": 0.01 + 0.002 * k} for k in range(len(names))],
        robot=SimpleNamespace(parameters=stiffness),
    )
    return SimpleNamespace(
        names=frozenset(names), hypothesis=every, theta=None, predictor=predictor, chi2=1.0, begin=begin
    )


def search_of(*candidates: str) -> Any:
    """A search with candidates that are fitted as they begin."""

    def together(fit: Any, additions: Any, without: Any) -> Any:
        rest = tuple(name for name in fit.names if name not in without)
        return fit_of((*(one.candidate.name for one in additions), *rest), *(float(one.start[0]) for one in additions))

    free = SimpleNamespace(name="time", encode=lambda value: value)
    return SimpleNamespace(
        settings=DiagnosisSettings(),
        candidates=lambda: [
            SimpleNamespace(name=one, effect=effects()[one.partition("@")[0]], free=(free,)) for one in candidates
        ],
        deadline=SimpleNamespace(stops=lambda: False),
        data=SimpleNamespace(record=SimpleNamespace(command=np.zeros(4))),
        rows=np.arange(4),
        together=together,
        completed=lambda one: one,
    )


@pytest.mark.parametrize(
    ("names", "worth", "expected"),
    [
        (LAGS, False, {"delay@all", "coulomb_friction@motor_1"}),
        (LAGS, True, {*LAGS, "coulomb_friction@motor_1"}),
        (LAGS[:1], False, {"delay@all", "coulomb_friction@motor_1"}),
        (LAGS[:1], True, {LAGS[0], "coulomb_friction@motor_1"}),
        (("delay@all", LAGS[0]), False, {"delay@all", LAGS[0], "coulomb_friction@motor_1"}),
        (("delay@all", *LAGS), False, {"delay@all", "coulomb_friction@motor_1"}),
        (BRAKES, False, {"delay@all", "coulomb_friction@motor_1"}),
        (BRAKES, True, {*BRAKES, "coulomb_friction@motor_1"}),
        (BRAKES[1:], False, {"delay@all", "coulomb_friction@motor_1"}),
        (BRAKES[1:], True, {BRAKES[1], "coulomb_friction@motor_1"}),
    ],
    ids=[
        "filters do as much",
        "filters do more",
        "one filter leaves more",
        "one leaves less",
        "one beside a delay",
        "beside a delay",
        "friction does as much",
        "does more",
        "that of one motor leaves more",
        "leaves less",
    ],
)
def test_what_makes_servos_late_becomes_one_delay_that_does_as_much(
    names: tuple[str, ...], worth: bool, expected: set[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Viscous friction b makes a servo of the stiffness k late by b / k; what is late already by a delay adds to it."""
    begin = {
        LAGS: 0.011,
        LAGS[:1]: 0.01,
        ("delay@all", *LAGS): 0.01 + 0.013,
        BRAKES: 0.011 / 2.0,
        BRAKES[1:]: 0.01 / 2.0,
    }.get(names)
    monkeypatch.setattr(exchange, "compared", lambda *_: None)
    monkeypatch.setattr(exchange, "worth", lambda *_: worth)
    monkeypatch.setattr(exchange, "_better", lambda *_: not worth)
    monkeypatch.setattr(exchange, "reduced", lambda _search, one, _fits, _removed: one)
    fits: list[Any] = []
    found = one_delay(search_of("delay@all"), fit_of((*names, "coulomb_friction@motor_1")), fits)
    assert found.names == expected
    assert [one.begin for one in fits] == ([] if begin is None else [pytest.approx((begin,))])


def test_filters_of_all_servos_begin_with_the_delay_that_they_replace() -> None:
    delayed = fit_of(("coulomb_friction@motor_1", "delay@all"))
    filtered = filters_for_delay(search_of(*LAGS), delayed)
    assert filtered is not None
    assert filtered.names == {*LAGS, "coulomb_friction@motor_1"}
    assert filtered.begin == pytest.approx((0.012, 0.012))  # type: ignore[attr-defined]
    assert filters_for_delay(search_of(*LAGS), fit_of(LAGS)) is None
    assert filters_for_delay(search_of(), delayed) is None
