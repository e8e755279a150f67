"""Sizes whose common scale a log does not tell."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexros.gap.answer.rivals import scale_doubt
from flexros.gap.candidates.candidate import Candidate, names_of
from flexros.gap.schema import CauseParameter
from tests.gap.diagnosis_logs import candidates_of

COULOMB, GAIN, INERTIA, DELAY = (
    "coulomb_friction@motor_1", "torque_gain_error@motor_1", "motor_inertia_error@motor_1", "delay@all",
)  # fmt: skip
NAMES = (f"{COULOMB}.level", f"{GAIN}.relative")


@dataclass(frozen=True, eq=False)
class Fit:
    """A fit with known sizes."""

    hypothesis: tuple[Candidate, ...]
    values: list[dict[str, float]]
    theta: None = None

    @property
    def names(self) -> frozenset[str]:
        return names_of(self.hypothesis)

    @property
    def predictor(self) -> Any:
        return SimpleNamespace(values=lambda _: self.values)


def fitted(**sizes: float) -> Fit:
    """A fit of friction and of one further effect."""
    every = {name.split("@")[0]: one for name, one in candidates_of().items()}
    hypothesis = tuple(every[name] for name in sizes)
    values = [{free.name: size for free in one.free} for one, size in zip(hypothesis, sizes.values(), strict=True)]
    return Fit(hypothesis, values)


def findings(rival: Fit) -> Any:
    """A gain of 0.85, with a rival of a probability of a quarter."""
    chosen = fitted(coulomb_friction=30.0, torque_gain_error=-0.15)
    explanations = SimpleNamespace(
        chosen=chosen, rivals=(chosen, rival), probabilities=np.array([0.75, 0.25]), detected=True
    )
    sizes = [
        {"level": CauseParameter(value=30.0, std=1.0, unit="N")},
        {"relative": CauseParameter(value=-0.15, std=0.02, unit="1")},
    ]
    return SimpleNamespace(
        explanations=explanations,
        data=None,
        held=None,
        settings=SimpleNamespace(rival=3.0),
        elsewhere=(),
        sizes=lambda _: sizes,
    )


@pytest.fixture(autouse=True)
def of_the_fit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scale_doubt, "covariance_of", lambda *_: (NAMES, np.diag([1.0, 0.02**2])))


def test_sizes_are_as_uncertain_as_a_rival_of_another_scale_makes_them() -> None:
    friction, gain = scale_doubt.parameters_of_answer(findings(fitted(coulomb_friction=36.0, motor_inertia_error=0.2)))
    assert friction["level"].std == pytest.approx(np.hypot(1.0, 6.0 * 0.5))
    assert gain["relative"].std == pytest.approx(np.hypot(0.02, 0.15 * 0.5))
    assert friction["level"].determined


def test_a_size_below_that_is_not_determined() -> None:
    friction, _ = scale_doubt.parameters_of_answer(findings(fitted(coulomb_friction=100.0, motor_inertia_error=0.2)))
    assert not friction["level"].determined


def test_a_rival_that_is_not_of_one_scale_says_nothing_of_sizes() -> None:
    friction, _ = scale_doubt.parameters_of_answer(findings(fitted(coulomb_friction=36.0, delay=0.01)))
    assert friction["level"].std == pytest.approx(1.0)
