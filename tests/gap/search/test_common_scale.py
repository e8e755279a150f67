"""Exchanges of a gain of a torque for an inertia, and of what a gain may be taken for."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from flexros.gap.deadline import Deadline
from flexros.gap.search import common_scale
from flexros.gap.search.common_scale import with_common_scale
from flexros.gap.search.proportion import other_scales
from flexros.record.premises import MEASURED, SIMULATED, Premises
from tests.gap.diagnosis_logs import candidates_of
from tests.gap.planar_arm import FRICTION, candidates_named, searched

if TYPE_CHECKING:
    from pathlib import Path

GAIN, INERTIA, BIAS, COULOMB = (
    f"{name}@motor_1" for name in ("torque_gain_error", "motor_inertia_error", "torque_bias", "coulomb_friction")
)
LOAD = "payload_error@tool"
GAINS = tuple(f"torque_gain_error@motor_{k}" for k in (1, 2, 3))


def fitted(*names: str) -> Any:
    """A fit of named effects."""
    every = candidates_of()
    predictor = SimpleNamespace(values=lambda _: [{"relative": 0.1} for _ in names])
    hypothesis = tuple(every[name] for name in names)
    return SimpleNamespace(hypothesis=hypothesis, names=frozenset(names), predictor=predictor, theta=None)


def tried(
    *names: str, monkeypatch: pytest.MonkeyPatch, premises: Premises = MEASURED, command: object = None
) -> list[str]:
    """What is tried in place of an effect of an explanation, which stays."""
    monkeypatch.setattr(common_scale, "_fitted", lambda _, exchange: exchange.new.name)
    monkeypatch.setattr(common_scale, "in_proportion", lambda fit, _: fit)
    monkeypatch.setattr(common_scale, "other_scales", lambda *_: [])
    search: Any = SimpleNamespace(
        premises=premises,
        data=SimpleNamespace(record=SimpleNamespace(command=command)),
        deadline=Deadline(),
        candidates=lambda: tuple(candidates_of().values()),
        completed=lambda fit: fit,
        parallel=lambda _, function, items: [function(one) for one in items],
    )
    chosen, fits = fitted(*names), []  # type: ignore[var-annotated]
    assert with_common_scale(search, chosen, fits) is chosen
    return fits


def test_a_constant_torque_has_the_gain_of_its_motor_as_a_rival(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a leg it had stood for a torque constant that was 15 % off, and rotor and friction bent."""
    assert tried(COULOMB, BIAS, monkeypatch=monkeypatch) == [GAIN]


def test_a_gain_has_the_inertias_that_it_moves_as_rivals(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a belt axis a load that was 25 % too small had been named as a gain, and all sizes were off by the factor."""
    assert set(tried(COULOMB, GAIN, monkeypatch=monkeypatch)) == {INERTIA, LOAD}


@pytest.mark.parametrize("inertia", [INERTIA, LOAD])
def test_an_inertia_gives_no_way_to_a_gain(inertia: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a measured harmonic drive the two predicted alike, and only the inertia was known to be wrong."""
    assert not tried(COULOMB, inertia, monkeypatch=monkeypatch)


@pytest.mark.parametrize(("premises", "command"), [(SIMULATED, None), (MEASURED, 1)], ids=["simulated", "servos"])
def test_other_logs_are_left_to_linear_theory_and_to_common_factors(
    premises: Premises, command: object, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert not tried(COULOMB, BIAS, monkeypatch=monkeypatch, premises=premises, command=command)


def test_a_gain_and_an_inertia_elsewhere_are_not_of_one_scale() -> None:
    every = candidates_of()
    assert common_scale.of_one_scale(every[GAIN], every[INERTIA])
    assert common_scale.of_one_scale(every[INERTIA], every[GAIN])
    assert not common_scale.of_one_scale(every[GAIN], replace(every[INERTIA], location="motor_2"))
    assert not common_scale.of_one_scale(every[GAIN], every[BIAS])


@pytest.mark.slow
def test_one_gain_takes_the_place_of_those_of_all_other_motors(tmp_path: Path) -> None:
    """A gain of the shoulder that was 8 % too small had been named as two too large ones, in an arm too heavy."""
    search = searched(tmp_path, *FRICTION, f"{GAINS[0]}:relative=-0.08")
    friction = tuple(one.partition(":")[0] for one in FRICTION)
    hypothesis = candidates_named(search, *friction, *GAINS[1:])
    predictor = search.null.predictor(hypothesis)
    sizes = [1.63, 0.87, 0.435, 0.087, 0.087]
    encoded = [one.free[0].encode(size) for one, size in zip(hypothesis, sizes, strict=True)]
    start = np.concatenate([encoded, np.zeros(predictor.tolerance.n_free)])
    wrong = search.completed(replace(search.null.fit, predictor=predictor, theta=start))
    (begun,) = other_scales(search, wrong)
    right = search.completed(begun)
    assert right.names == {*friction, GAINS[0]}
    assert right.chi2 < wrong.chi2
    found = dict(zip((one.name for one in right.hypothesis), right.predictor.values(right.theta), strict=True))
    assert found[GAINS[0]]["relative"] == pytest.approx(-0.08, abs=0.02)
    assert found[friction[0]]["level"] == pytest.approx(1.5, rel=0.05)


@pytest.mark.slow
def test_more_gains_than_before_are_not_tried(tmp_path: Path) -> None:
    """One gain of three that is wrong is simpler than two that are."""
    search = searched(tmp_path, *FRICTION, f"{GAINS[0]}:relative=-0.08")
    hypothesis = candidates_named(search, GAINS[0])
    predictor = search.null.predictor(hypothesis)
    start = np.concatenate([[hypothesis[0].free[0].encode(-0.08)], np.zeros(predictor.tolerance.n_free)])
    assert not list(other_scales(search, replace(search.null.fit, predictor=predictor, theta=start)))
