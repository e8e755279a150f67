"""Explanations of a measured log within its floor: what both logs are for is added."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import pytest

from flexros.gap.answer import told_apart as module
from flexros.gap.answer.told_apart import told_apart
from flexros.gap.deadline import Deadline
from flexros.gap.held_out.closed_share import ClosedShare
from flexros.gap.settings import DiagnosisSettings
from flexros.record.premises import MEASURED, SIMULATED, Premises

N = 1000
DELAY, LAGS, MODE, ROTOR = (
    "delay@all",
    ("servo_command_lag@motor_1", "servo_command_lag@motor_2"),
    "extra_mode@tool",
    "rotor",
)
COULOMB, STRIBECK, RIPPLE = "coulomb_friction@motor_1", "stribeck_friction@motor_1", "torque_ripple@motor_2"
BIAS = "torque_bias@motor_2"


@dataclass(frozen=True, eq=False)
class Fit:
    """A fit of named effects, with what it leaves of the fitted and of the held-out log, over the floor."""

    kept: tuple[str, ...]
    level: float
    held: float

    @property
    def names(self) -> frozenset[str]:
        return frozenset(self.kept)

    @property
    def chi2(self) -> float:
        return self.level * N

    @property
    def hypothesis(self) -> list[Any]:
        return [SimpleNamespace(name=name) for name in self.kept]

    @property
    def predictor(self) -> Any:
        return SimpleNamespace(values=lambda _: [{} for _ in self.kept])

    theta = None


def found(
    fits: list[Fit],
    monkeypatch: pytest.MonkeyPatch,
    premises: Premises = MEASURED,
    *,
    filters: Fit | None = None,
    limited: Fit | None = None,
    exchanged: Fit | None = None,
    worse: bool = False,
    most: float = float("inf"),
) -> Fit:
    """Choose between fits, of which the first is the chosen explanation.

    Args:
        fits: The fits.
        monkeypatch: Replaces what they are compared by.
        premises: Where the log is from.
        filters: The chosen one with filters of the commands in place of the delay.
        limited: A fit that ends at a limit.
        exchanged: What the search takes in its place.
        worse: Whether that is surely worse one sample ahead.
        most: Fits without an effect after which the time is over.
    """
    fitted: list[frozenset[str]] = []

    def without(fit: Fit, *names: str) -> Fit:
        fitted.append(fit.names.difference(names))
        return every[fitted[-1]]

    every = {fit.names: fit for fit in fits}
    comparison = SimpleNamespace(
        fits=fits,
        threshold=10.0,
        level=lambda fit: fit.level,
        penalty=lambda fit: 5.0 * len(fit.kept),
        probabilities=lambda rivals: [float(abs(fit.level - fits[0].level) < 0.01) for fit in rivals],
    )

    def share(before: float, more: float, less: float, _: float, floor: float = 1.0) -> ClosedShare | None:
        value = (more - less) / (before - floor)
        return ClosedShare(value, (value - 0.1, value + 0.1)) if before > floor else None

    replaced = {
        "compared": lambda *_: comparison,
        "best_of_each": list,
        "at_limits": lambda fit: [fit] if fit is limited else [],
        "filters_for_delay": lambda *_: filters,
        "exchanged": lambda *_: exchanged,
        "surely_worse": lambda *_: worse,
        "begun_at": lambda one, *_: one.name,
        "errors_ahead": lambda fit, _: fit.held,
        "on_held_out": lambda fit, _: SimpleNamespace(chi2=fit.held * N),
        "share_between": share,
    }
    for name, value in replaced.items():
        monkeypatch.setattr(module, name, value)
    search: Any = SimpleNamespace(
        premises=premises,
        deadline=Deadline(interrupted=lambda: len(fitted) >= most),
        settings=DiagnosisSettings(),
        data=SimpleNamespace(n_values=N),
        completed=lambda fit: fit,
        without=without,
        together=lambda fit, additions, without: Fit((*(fit.names - without), *additions), fit.level, fit.held),
        rows=[],
        candidates=list,
        directions=lambda *_: [],
        parallel=lambda _, function, items: [function(one) for one in items],
    )
    held: Any = SimpleNamespace(record=SimpleNamespace(sample_time=1e-3))
    answer: Any = told_apart(search, fits[0], fits, held)  # type: ignore[arg-type]
    assert isinstance(answer, Fit)
    return answer


@pytest.mark.parametrize(("level", "held", "added"), [
    (0.6, 1.5, True),
    (0.6, 3.9, False),  # less than an effect must remove of the held-out log
    (0.6, 5.0, False),
    (0.795, 1.5, False),  # the fitted log gains less than a parameter costs
])  # fmt: skip
def test_what_both_logs_are_for_is_added(
    level: float, held: float, added: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    fits = [Fit((COULOMB,), 0.8, 4.0), Fit((COULOMB, STRIBECK), level, held)]
    assert found(fits, monkeypatch).names == ({COULOMB, STRIBECK} if added else {COULOMB})


def test_of_several_further_effects_those_stay_that_the_held_out_log_is_for(monkeypatch: pytest.MonkeyPatch) -> None:
    fits = [
        Fit((COULOMB,), 0.8, 4.0),
        Fit((COULOMB, STRIBECK, RIPPLE), 0.5, 1.5),
        Fit((COULOMB, STRIBECK), 0.6, 1.4),
        Fit((COULOMB, RIPPLE), 0.75, 3.9),
    ]
    assert found(fits, monkeypatch).names == {COULOMB, STRIBECK}


def test_further_effects_that_the_held_out_log_is_not_for_go_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Fits with one of them less alone are all that there are: two rounds of them took too long on six axes."""
    fits = [
        Fit((COULOMB,), 0.8, 4.0),
        Fit((COULOMB, STRIBECK, RIPPLE, BIAS), 0.5, 1.5),
        Fit((COULOMB, STRIBECK, BIAS), 0.6, 1.4),
        Fit((COULOMB, STRIBECK, RIPPLE), 0.6, 1.45),
        Fit((COULOMB, RIPPLE, BIAS), 0.75, 3.9),
        Fit((COULOMB, STRIBECK), 0.61, 1.4),
    ]
    assert found(fits, monkeypatch).names == {COULOMB, STRIBECK}


@pytest.mark.parametrize("most", [1, 2])
def test_what_the_time_does_not_suffice_to_confirm_is_not_added(most: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """An arm of six axes had seven false effects of sizes within two deviations, as the time was over."""
    fits = [
        Fit((COULOMB,), 0.8, 4.0),
        Fit((COULOMB, STRIBECK, RIPPLE), 0.5, 1.5),
        Fit((COULOMB, STRIBECK), 0.6, 1.4),
        Fit((COULOMB, RIPPLE), 0.75, 3.9),
    ]
    assert found(fits, monkeypatch, most=most).names == {COULOMB}


def test_above_the_floor_and_in_a_simulated_log_the_search_has_decided(monkeypatch: pytest.MonkeyPatch) -> None:
    fits = [Fit((COULOMB,), 20.0, 4.0), Fit((COULOMB, STRIBECK), 15.0, 1.5)]
    assert found(fits, monkeypatch).names == {COULOMB}
    within = [Fit((COULOMB,), 0.8, 4.0), Fit((COULOMB, STRIBECK), 0.6, 1.5)]
    assert found(within, monkeypatch, SIMULATED).names == {COULOMB}


@pytest.mark.parametrize(("level", "held", "taken"), [
    (0.6, 0.3, True),  # the servos rest: what is left is less than noise
    (0.6, 0.8, False),
    (0.795, 0.3, False),  # the fitted log gains less than a parameter costs
])  # fmt: skip
def test_filters_of_the_commands_take_the_place_of_one_delay_where_both_logs_are_for_them(
    level: float, held: float, taken: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    filters = Fit(LAGS, level, held)
    one_less = [Fit((name,), 5.0, 7.0) for name in LAGS]
    answer = found([Fit((DELAY,), 0.8, 0.9), *one_less], monkeypatch, filters=filters)
    assert answer.names == (set(LAGS) if taken else {DELAY})


def test_a_filter_of_a_servo_that_the_held_out_log_does_not_confirm_is_left_out(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    fits = [Fit((DELAY,), 0.8, 4.0), Fit(LAGS[:1], 0.6, 1.4), Fit(LAGS[1:], 0.8, 5.0), Fit((), 5.0, 7.0)]
    assert found(fits, monkeypatch, filters=Fit(LAGS, 0.6, 1.4)).names == set(LAGS[:1])


@pytest.mark.parametrize("worse", [False, True])
def test_what_ends_at_a_limit_beside_filters_gives_way_unless_that_is_surely_worse(
    worse: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A mode had stood for a rotor beside the delay, and ended at the limits of its range beside filters."""
    filters, other = Fit((*LAGS, MODE), 0.6, 1.4), Fit((*LAGS, ROTOR), 0.61, 1.5)
    fits = [Fit((DELAY, MODE), 0.8, 4.0), *(Fit((name, MODE), 5.0, 7.0) for name in LAGS)]
    answer = found(fits, monkeypatch, filters=filters, limited=filters, exchanged=other, worse=worse)
    assert answer.names == ({DELAY, MODE} if worse else {*LAGS, ROTOR})


def test_a_rival_that_the_fitted_log_does_not_tell_is_one_beside_filters_and_the_delay_in_none(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    viscous, gain = "viscous_friction@motor_1", "servo_stiffness_error@motor_1"
    fits = [Fit((DELAY, viscous), 0.8, 4.0), Fit((DELAY, gain), 0.801, 4.1), Fit((DELAY, RIPPLE), 0.9, 4.0)]
    filters = Fit((*LAGS, viscous), 0.6, 1.4)
    one_less = [Fit((name, viscous), 5.0, 7.0) for name in LAGS]
    fits += one_less
    assert found(fits, monkeypatch, filters=filters) is filters
    assert [fit.names for fit in fits] == [*(fit.names for fit in one_less), filters.names, {*LAGS, gain}]
