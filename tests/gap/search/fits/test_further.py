"""Explanations fitted with further candidates, some of them around the nominal numbers of the model."""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexros.gap.search.fits import further
from flexros.gap.settings import DiagnosisSettings
from flexros.record.premises import SIMULATED
from tests.gap.diagnosis_logs import candidates_of


def fit(*names: str) -> Any:
    return SimpleNamespace(names=frozenset(names), hypothesis=names)


@pytest.mark.parametrize(
    ("ended", "left"), [((), ("first", "drag", "limit")), (("limit",), ("first", "drag")), (("limit", "drag"), None)]
)
def test_a_further_effect_that_ended_at_its_last_limit_is_not_added(
    ended: tuple[str, ...], left: tuple[str, ...] | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Beside a limit of torques that stood for others these were left out, and it itself in the end."""
    monkeypatch.setattr(further, "ended_at_last", lambda _: set(ended))
    search: Any = SimpleNamespace(torques_decide=False)
    search.without = lambda one, *names: fit(*(name for name in one.hypothesis if name not in names))
    grown = fit("first", "drag", "limit")
    search.torques_decide = True
    found = further._without_ended(search, fit("first"), grown)
    assert (None if found is None else found.hypothesis) == left
    search.torques_decide = False
    assert further._without_ended(search, fit("first"), grown) is grown


@dataclass(frozen=True, eq=False)
class Strained:
    """A fit of one effect whose three tolerated numbers are out of tolerance."""

    predictor: Any
    theta: Any
    chi2: float


class Screened:
    """A search that notes around which parameters it screens candidates, and from which it fits."""

    def __init__(self) -> None:
        self.settings, self.premises = DiagnosisSettings(), SIMULATED
        self.data, self.deadline = None, SimpleNamespace(stops=lambda: False)
        self.around: list[list[float]] = []

    def candidates(self) -> list[str]:
        return ["gain"]

    def with_nominal_numbers(self, fit: Strained) -> Strained:
        theta = np.where(np.arange(len(fit.theta)) < fit.predictor.n_effect, fit.theta, 0.0)
        return replace(fit, theta=theta, chi2=900.0)

    def directions(self, candidates: Any, fit: Strained) -> Any:
        self.around.append(fit.theta.tolist())
        return candidates

    def surroundings(self, fit: Strained) -> None:
        self.around.append(fit.theta.tolist())

    def additions(self, directions: Any, *_: Any) -> Any:
        return directions


@pytest.mark.parametrize("strained", [True, False])
def test_beside_numbers_out_of_tolerance_candidates_are_tried_from_the_nominal_numbers(
    strained: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun: list[Any] = []
    monkeypatch.setattr(further, "compared", lambda *_: SimpleNamespace(beyond_tolerance=lambda _: strained))
    monkeypatch.setattr(further, "fitted_with", lambda _search, one, trials, _fits: begun.append((one, trials)))
    search: Any = Screened()
    fit: Any = Strained(SimpleNamespace(n_effect=1), np.array([0.3, 4.0, -5.0, 2.0]), 100.0)
    further.from_nominal_numbers(search, fit, [])
    assert search.around == ([[0.3, 0.0, 0.0, 0.0]] * 2 if strained else [])
    assert [(one.chi2, trials) for one, trials in begun] == ([(900.0, [["gain"]])] if strained else [])


@pytest.mark.parametrize(("left", "taken"), [(40.0, True), (95.0, False)])
def test_friction_of_all_motors_is_added_from_the_nominal_numbers(
    left: float, taken: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A ripple stood for a constant torque beside numbers at their limits, and could not be left out any more."""
    begun: list[Any] = []

    def fitted(_search: Any, one: Any, trials: Any, _fits: Any) -> Any:
        begun.append((one.chi2, [found.candidate.name for found in trials[0]]))
        return SimpleNamespace(chi2=left)

    def additions(directions: Any, *_: Any) -> Any:
        found = [SimpleNamespace(candidate=one, change=np.ones(3)) for one in directions]
        for one in found:
            one.sized = lambda _size, one=one: one
        return found

    search: Any = Screened()
    competing = candidates_of()
    search.additions = additions
    search.candidates, search.directions = competing.values, lambda candidates, _: candidates
    search.surroundings = lambda _: SimpleNamespace(sizes=lambda changes: np.ones(changes.shape[1]))
    strained = SimpleNamespace(beyond_tolerance=lambda _: True, removed=lambda _, after: 1 - after.chi2 / 100.0)
    monkeypatch.setattr(further, "compared", lambda *_: strained)
    monkeypatch.setattr(further, "fitted_with", fitted)
    one: Any = Strained(SimpleNamespace(n_effect=1), np.array([0.3, 4.0, -5.0, 2.0]), 100.0)
    object.__setattr__(one, "names", {"coulomb_friction@motor_1"})
    grown = further.with_usual(search, one, [])
    usual = ("coulomb_friction", "viscous_friction", "torque_bias")
    names = [name for name in competing if name.startswith(usual) and name != "coulomb_friction@motor_1"]
    assert begun == [(900.0, names)]
    assert (grown is not None) is taken
