"""The most probable explanation that the held-out log does not refute is the chosen one."""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexros.gap.answer.rivals import most_probable as module
from flexros.gap.answer.rivals.most_probable import most_probable
from flexros.gap.held_out.closed_share import ClosedShare
from flexros.gap.search.forward_selection import Explanations
from flexros.gap.search.model_probability import ModelComparison
from flexros.gap.settings import RankingSettings
from flexros.record.premises import MEASURED, SIMULATED, Premises


@dataclass(frozen=True, eq=False)
class Fit:
    """A fit of named effects."""

    effects: str
    finished: bool = False

    @property
    def hypothesis(self) -> tuple[str, ...]:
        return tuple(self.effects)

    @property
    def names(self) -> frozenset[str]:
        return frozenset(self.effects)


def chosen_of(
    monkeypatch: pytest.MonkeyPatch,
    odds: dict[str, float],
    chosen: str,
    worse: str = "",
    rise: float = 0.01,
    share: float = 0.0,
    premises: Premises = MEASURED,
) -> Explanations:
    """The explanations after the choice, of fits with some odds of which one predicts the held-out log worse."""
    fits: Any = {name: Fit(name) for name in ("", *odds)}
    left = np.array([0.0, *odds.values()])
    comparison = ModelComparison(fits[""], tuple(fits.values()), 1000)
    explanations = Explanations(comparison, fits[chosen], tuple(fits.values()), left / left.sum(), detected=True)
    monkeypatch.setattr(module, "surely_worse", lambda fit, *_: not share and fit.effects == worse)
    monkeypatch.setattr(module, "on_held_out", lambda fit, _: SimpleNamespace(chi2=1.0 + rise * (fit.effects == worse)))
    monkeypatch.setattr(module, "errors_ahead", lambda fit, _: fit)
    shares = {worse: ClosedShare(share, (share / 2, 2 * share))}
    monkeypatch.setattr(module, "share_between", lambda _, fit, *__: shares.get(fit.effects))
    search: Any = SimpleNamespace(
        premises=premises,
        settings=SimpleNamespace(ranking=RankingSettings()),
        completed=lambda fit: replace(fit, finished=True),
    )
    held: Any = SimpleNamespace(n_values=10_000, record=SimpleNamespace(sample_time=1e-3))
    return most_probable(search, explanations, held)


def names(found: Explanations) -> list[str]:
    return [fit.effects for fit in found.rivals if fit.effects]  # type: ignore[attr-defined]


@pytest.mark.parametrize("odds", [{"ab": 1.0, "ac": 3.0}, {"ab": 2.0, "ac": 3.0, "ad": 4.0}, {"ab": 1.0, "a": 20.0}])
def test_the_most_probable_explanation_is_the_chosen_one(
    monkeypatch: pytest.MonkeyPatch, odds: dict[str, float]
) -> None:
    """A leg had a friction of 4 % in its patch, and the answer called another one six times as probable."""
    found = chosen_of(monkeypatch, odds, "ab")
    assert found.chosen is found.rivals[int(np.argmax(found.probabilities))]


def test_what_takes_the_place_of_the_chosen_one_is_fitted_to_its_end(monkeypatch: pytest.MonkeyPatch) -> None:
    found = chosen_of(monkeypatch, {"ab": 1.0, "ac": 3.0}, "ab")
    assert found.chosen.finished  # type: ignore[attr-defined]
    assert found.chosen in found.comparison.fits


@pytest.mark.parametrize("share", [0.0, 0.1], ids=["one sample ahead", "0.1 s ahead"])
def test_what_the_held_out_log_refutes_is_no_rival(monkeypatch: pytest.MonkeyPatch, share: float) -> None:
    """A gain of the torque fitted a log of a drive better than its inertia, and left four times as much of another."""
    found = chosen_of(monkeypatch, {"ab": 1.0, "ac": 3.0}, "ab", worse="ac", share=share)
    assert found.chosen.effects == "ab"  # type: ignore[attr-defined]
    assert names(found) == ["ab"]
    assert found.probabilities.sum() == pytest.approx(1.0)


@pytest.mark.parametrize(("rise", "share"), [(1e-4, 0.0), (0.0, 3e-6)], ids=["one sample ahead", "0.1 s ahead"])
def test_a_held_out_log_that_both_predict_alike_refutes_neither(
    monkeypatch: pytest.MonkeyPatch, rise: float, share: float
) -> None:
    """A friction that was not there left 3e-6 less of the gap of a leg, by more than chance."""
    found = chosen_of(monkeypatch, {"ab": 1.0, "a": 9.0}, "ab", worse="a", rise=rise, share=share)
    assert found.chosen.effects == "a"  # type: ignore[attr-defined]


def test_rivals_have_no_more_effects_than_a_smaller_explanation_that_is_chosen(monkeypatch: pytest.MonkeyPatch) -> None:
    found = chosen_of(monkeypatch, {"ab": 1.0, "ac": 5.0, "a": 20.0}, "ab")
    assert names(found) == ["a"]


def test_simulated_logs_are_left_to_the_search(monkeypatch: pytest.MonkeyPatch) -> None:
    found = chosen_of(monkeypatch, {"ab": 1.0, "ac": 3.0}, "ab", premises=SIMULATED)
    assert found.chosen.effects == "ab"  # type: ignore[attr-defined]
