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
COULOMB, STRIBECK, RIPPLE = "coulomb_friction@motor_1", "stribeck_friction@motor_1", "torque_ripple@motor_2"


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


def found(fits: list[Fit], monkeypatch: pytest.MonkeyPatch, premises: Premises = MEASURED) -> Fit:
    """Choose between fits, of which the first is the chosen explanation."""
    every = {fit.names: fit for fit in fits}
    comparison = SimpleNamespace(
        fits=fits, threshold=10.0, level=lambda fit: fit.level, penalty=lambda fit: 5.0 * len(fit.kept)
    )

    def share(before: float, more: float, less: float, _: float) -> ClosedShare:
        value = (more - less) / (before - 1.0)
        return ClosedShare(value, (value - 0.1, value + 0.1))

    replaced = {
        "compared": lambda *_: comparison,
        "best_of_each": list,
        "at_limits": lambda _: [],
        "errors_ahead": lambda fit, _: fit.held,
        "on_held_out": lambda fit, _: SimpleNamespace(chi2=fit.held * N),
        "share_between": share,
    }
    for name, value in replaced.items():
        monkeypatch.setattr(module, name, value)
    search: Any = SimpleNamespace(
        premises=premises,
        deadline=Deadline(),
        settings=DiagnosisSettings(),
        data=SimpleNamespace(n_values=N),
        completed=lambda fit: fit,
        without=lambda fit, name: every[fit.names - {name}],
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


def test_above_the_floor_and_in_a_simulated_log_the_search_has_decided(monkeypatch: pytest.MonkeyPatch) -> None:
    fits = [Fit((COULOMB,), 20.0, 4.0), Fit((COULOMB, STRIBECK), 15.0, 1.5)]
    assert found(fits, monkeypatch).names == {COULOMB}
    within = [Fit((COULOMB,), 0.8, 4.0), Fit((COULOMB, STRIBECK), 0.6, 1.5)]
    assert found(within, monkeypatch, SIMULATED).names == {COULOMB}
