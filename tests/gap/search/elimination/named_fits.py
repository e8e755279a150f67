"""Fits of named effects and a search that knows what each leaves, for tests of what is left out."""

from __future__ import annotations

from dataclasses import dataclass
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

from flexros.effects import effects
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.deadline import Deadline
from flexros.gap.settings import DiagnosisSettings
from flexros.record.premises import MEASURED

INERTIA, STIFFNESS = "motor_inertia_error@motor_1", "stiffness_error@body_2.ry"
LEFT_OUT = "tool_load@tool"
LOAD = "load_dependent_friction@motor_1"
DRIFT, OFFSET = "friction_drift@motor_1", "encoder_offset@motor_2"
COULOMB, VISCOUS, BIAS = "coulomb_friction@motor_1", "viscous_friction@motor_1", "torque_bias@motor_2"
N = 1000


@dataclass(frozen=True)
class Fit:
    """A fit of named effects."""

    kept: tuple[str, ...]
    chi2: float
    prior_penalty: float = 0.0
    free: tuple[str, ...] = ("size",)

    @property
    def names(self) -> frozenset[str]:
        return frozenset(self.kept)

    @property
    def hypothesis(self) -> tuple[Any, ...]:
        free = tuple(SimpleNamespace(name=name, high=10.0) for name in self.free)
        parts = [(one, *one.split("@")) for one in self.kept]
        return tuple(
            SimpleNamespace(name=one, effect=effects()[effect], location=location, free=free)
            for one, effect, location in parts
        )


class Search:
    """A search whose fits and estimates are given by the effects they have.

    Args:
        chi2: Sum of squares of a fit, by its effects.
        estimated: Sum of squares without one of several effects, by linear theory.
        base: Effects that the torques show.
    """

    torques_decide = from_torques = True
    fall = 0.0

    def __init__(self, chi2: dict[frozenset[str], float], estimated: dict[str, float], base: tuple[str, ...]) -> None:
        self.chi2, self.estimated = chi2, estimated
        self.base = Fit(base, 0.0)
        self.of_torques = self.base.names
        robot = SimpleNamespace(n_coordinates=2, n_motors=2)
        tolerance = Tolerance(("motor_1.inertia",), (0.03,))
        null = SimpleNamespace(predictor=SimpleNamespace(tolerance=tolerance))
        self.null = SimpleNamespace(fit=null, model=SimpleNamespace(robot=robot))
        self.premises = MEASURED
        self.data = SimpleNamespace(n_values=N, negligible=0.0, record=SimpleNamespace(command=None))
        self.settings = DiagnosisSettings()
        self.deadline = Deadline()

    def shown_by_torques(self, fit: Fit) -> frozenset[str]:
        return self.base.names & fit.names

    def surroundings(self, fit: Fit) -> Any:
        return SimpleNamespace(least=fit.chi2, fall=self.fall)

    def removals(self, fit: Fit, surroundings: Any) -> list[Any]:
        return [SimpleNamespace(least=surroundings.least + self.estimated[name]) for name in fit.kept]

    def removals_together(self, fit: Fit, surroundings: Any, sets: list[list[str]]) -> list[Any]:
        del fit
        return [SimpleNamespace(least=surroundings.least + sum(self.estimated[name] for name in one)) for one in sets]

    def without(self, fit: Fit, *names: str) -> Fit:
        rest = tuple(name for name in fit.kept if name not in names)
        return Fit(rest, self.chi2[frozenset(rest)])

    def candidates(self) -> tuple[Any, ...]:
        return ()

    def directions(self, candidates: list[Any], fit: Fit) -> list[Any]:
        del fit
        return candidates

    def additions(self, directions: list[Any], fit: Fit, surroundings: Any) -> list[Any]:
        del fit, surroundings
        return directions

    def together(self, fit: Fit, additions: list[Any]) -> Fit:
        kept = (*fit.kept, *(one.name for one in additions))
        return Fit(kept, self.chi2[frozenset(kept)])

    def completed(self, fit: Fit) -> Fit:
        return fit

    def parallel(self, _: str, function: Any, items: list[str], *, needed: int) -> list[Any]:
        return [function(one) for one in items[:needed]]


def size_of(value: float, std: float) -> Any:
    """Size of an effect; without a deviation the log does not determine it."""
    return SimpleNamespace(value=value, std=std, determined=std > 0)


def plain_rules(monkeypatch: pytest.MonkeyPatch, *modules: ModuleType) -> None:
    """Friction is clear once it is alone at its motor; an effect must remove a fifth of what is left.

    Args:
        monkeypatch: Replaces the rules.
        modules: Where they are replaced.
    """

    def sizes(fit: Fit, _: Any) -> list[dict[str, Any]]:
        both = {COULOMB, VISCOUS} <= fit.names
        return [{"size": size_of(1.0, 1.0 if both else 0.1)} for _ in fit.kept]

    def worth(search: Any, comparison: Any, before: Fit, after: Fit, removed: float) -> bool:
        return before.chi2 - after.chi2 > removed * before.chi2

    def removed(before: Fit, after: Fit) -> float:
        return (before.chi2 - after.chi2) / (before.chi2 - N)

    comparison = SimpleNamespace(threshold=6.0, beyond_tolerance=lambda _: False, removed=removed)
    rules = {"parameters_of": sizes, "worth": worth, "best_of_each": list, "compared": lambda *_: comparison}
    rules["more_than_chance"] = lambda _, fit: fit.chi2 > N
    for module in modules:
        for name in rules.keys() & vars(module).keys():
            monkeypatch.setattr(module, name, rules[name])
