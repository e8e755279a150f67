"""What limits an answer."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexros.effects import parse_effect
from flexros.gap.answer import warnings
from flexros.gap.candidates.tolerance import Tolerance
from flexros.robot import load_robot


@pytest.mark.parametrize(
    ("sizes", "servos", "warned"),
    [((-0.48, -0.66), False, True), ((-0.48, -0.1), False, False), ((-0.48, -0.66), True, False)],
)
def test_torques_of_several_motors_that_act_by_other_factors_have_another_unit(
    monkeypatch: pytest.MonkeyPatch, sizes: tuple[float, float], servos: bool, warned: bool
) -> None:
    robot = load_robot("elbow")
    placed = [parse_effect(f"torque_gain_error@motor_{k + 1}:relative={size}", "test") for k, size in enumerate(sizes)]
    monkeypatch.setattr(warnings, "placed_effects", lambda _: placed)
    record = SimpleNamespace(imported=True, command=np.zeros((2, 2)) if servos else None)  # no torque was recorded
    findings: Any = SimpleNamespace(
        explanations=SimpleNamespace(chosen=None),
        data=SimpleNamespace(record=record),
        model=SimpleNamespace(robot=robot),
    )
    texts = warnings._unit_warnings(findings)
    assert bool(texts) is warned
    assert all("motor_1: 0.52" in text and "motor_2: 0.34" in text for text in texts)


@pytest.mark.parametrize(("after", "latter"), [(233.0, True), (12.0, False)])
@pytest.mark.parametrize(("x", "warned"), [(-0.67, True), (0.02, False)])
def test_a_slant_larger_than_a_careless_mounting_may_be_another_force(
    x: float, warned: bool, after: float, latter: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An elastic tether had become a tilt of 46 deg, and most of the gap was closed."""
    placed = [parse_effect(f"base_tilt@base:x={x},y=0.045", "test")]
    monkeypatch.setattr(warnings, "placed_effects", lambda _: placed)
    settings = SimpleNamespace(floors=2.0)
    findings: Any = SimpleNamespace(explanations=SimpleNamespace(chosen=None), settings=settings)
    gap: Any = SimpleNamespace(after=after, tolerance_floor=10.6)
    texts = warnings._unusual(findings, gap)
    assert bool(texts) is warned
    assert all("base_tilt@base turns gravity by 38 deg" in text and "tether" in text for text in texts)
    assert all(text.endswith("What is left speaks for the latter") is latter for text in texts)


@pytest.mark.parametrize(
    ("kept", "detected", "warned"),
    [
        ({"rotor_inertia@motor_2", "rotor_inertia@motor_1"}, True, True),
        (set(), True, False),
        ({"rotor_inertia@motor_1"}, False, False),
    ],
)
def test_a_model_that_predicts_nothing_without_what_it_lacks_is_told(
    kept: set[str], detected: bool, warned: bool
) -> None:
    findings: Any = SimpleNamespace(
        as_given=SimpleNamespace(kept=kept), explanations=SimpleNamespace(detected=detected)
    )
    texts = warnings._hopeless_as_given(findings)
    assert bool(texts) is warned
    assert all("lacks rotor_inertia@motor_1, rotor_inertia@motor_2, without which" in text for text in texts)


@pytest.mark.parametrize(
    ("after", "floor", "warned"), [(18.3, 20.8, True), (1.2, 20.8, False), (300.0, 20.8, False), (1.0, None, False)]
)
def test_what_the_tolerance_of_torques_may_hide_is_told(after: float, floor: float | None, warned: bool) -> None:
    findings: Any = SimpleNamespace(data=SimpleNamespace(measurement=SimpleNamespace(signal_tolerance=0.05)))
    gap: Any = SimpleNamespace(after=after, tolerance_floor=floor)
    texts = warnings._within_tolerance(findings, gap)
    assert bool(texts) is warned
    assert all("off by 5 % of their rms" in text and "tolerance of torque of 0.005" in text for text in texts)


@pytest.mark.parametrize(("tolerance", "advised"), [(0.05, True), (0.02, True), (0.005, False), (0.001, False)])
def test_no_tolerance_is_advised_that_counts_already(tolerance: float, advised: bool) -> None:
    findings: Any = SimpleNamespace(data=SimpleNamespace(measurement=SimpleNamespace(signal_tolerance=tolerance)))
    gap: Any = SimpleNamespace(after=18.3, tolerance_floor=20.8)
    (text,) = warnings._within_tolerance(findings, gap)
    assert ("state a tolerance of torque of 0.005" in text) is advised


@pytest.mark.parametrize(("after", "own", "begin", "warned"), [
    (50.0, 2.0, 0.0, True), (15.0, 2.0, 0.0, False), (50.0, 30.0, 0.0, False), (50.0, 2.0, 10.0, False),
])  # fmt: skip
def test_a_held_out_log_that_shows_more_is_told(
    after: float, own: float, begin: float, warned: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of point-to-point motion 20 of 25 effects were found, of a log with more speeds all but one."""
    monkeypatch.setattr(warnings, "errors_ahead", lambda *_: SimpleNamespace(mean=own))
    monkeypatch.setattr(warnings, "tolerance_floor", lambda *_: 5.0)
    premises = SimpleNamespace(floor_is_noise=False)
    fitted = SimpleNamespace(begin=0.0, n_samples=100, sample_time=0.01, premises=premises)
    findings: Any = SimpleNamespace(
        explanations=SimpleNamespace(chosen=None),
        data=SimpleNamespace(record=fitted),
        held=SimpleNamespace(record=SimpleNamespace(begin=begin)),
        settings=SimpleNamespace(floors=2.0),
    )
    gap: Any = SimpleNamespace(after=after, tolerance_floor=5.0)
    assert bool(warnings._less_excited(findings, gap)) is warned


def test_what_the_held_out_log_took_out_is_named_with_the_reason() -> None:
    friction, soft = "coulomb_friction@motor_1", "stiffness_error@body_2.rz"
    findings: Any = SimpleNamespace(withdrawn=(friction,), fitted_around=(soft,))
    of_friction, of_soft = warnings._taken_out(findings)
    assert f"{friction} explains a part of the fitted log, but the held-out log does not confirm it" in of_friction
    assert f"the size of {soft} ended at the last limit of its search" in of_soft
    assert all("check the patch on a third" in text for text in (of_friction, of_soft))


def test_numbers_far_out_of_tolerance_are_stated() -> None:
    tolerance = Tolerance(("body_1.mass", "body_1.inertia.yy"), (0.02, 0.02))
    chosen: Any = SimpleNamespace(predictor=SimpleNamespace(tolerance=tolerance), deviations=np.array([5.0, 1.0]))
    lacked: set[str] = set()
    findings: Any = SimpleNamespace(
        explanations=SimpleNamespace(chosen=chosen, detected=True),
        unknown=SimpleNamespace(names=lambda _: lacked),
        model=SimpleNamespace(robot=None),
    )
    (text,) = warnings._strained(findings)
    assert "body_1.mass by +10.5 %, 5.3 times its tolerance of 2 %" in text
    assert "inertia" not in text
    assert "A patch has them but for those that no effect changes, such as lengths." in text
    lacked.add("body_1.mass")
    assert not warnings._strained(findings)  # what the model lacked is stated elsewhere, and in the patch
    lacked.clear()
    findings.explanations.detected = False
    assert not warnings._strained(findings)  # torques are not exact
    findings.explanations.detected = True
    chosen.deviations = np.array([2.0, 1.0])
    assert not warnings._strained(findings)


@pytest.mark.parametrize(
    ("effect", "there_and_back", "rests", "warned"),
    [
        ("coulomb_friction@motor_2:level=1", False, 0, True),
        ("torque_bias@motor_2:level=1", False, 0, True),
        ("coulomb_friction@motor_2:level=1", True, 0, False),
        ("coulomb_friction@motor_2:level=1", False, 200, False),
        ("viscous_friction@motor_2:coefficient=1", False, 0, False),
    ],
)
def test_a_motor_that_moves_one_way_does_not_tell_friction_from_a_bias(
    monkeypatch: pytest.MonkeyPatch, effect: str, there_and_back: bool, rests: int, warned: bool
) -> None:
    """At rest only friction balances what acts, so that a log with rests tells them apart."""
    monkeypatch.setattr(warnings, "placed_effects", lambda _: [parse_effect(effect, "test")])
    time = 0.01 * np.arange(1000)
    moved = np.sin(time) if there_and_back else 3 * time + 0.5 * np.sin(2 * time)
    moved = np.concatenate([np.full(rests, moved[0]), moved])
    record = SimpleNamespace(
        position=np.column_stack([np.zeros_like(moved), moved]), valid=np.ones(len(moved), dtype=bool)
    )
    findings: Any = SimpleNamespace(
        explanations=SimpleNamespace(chosen=None),
        data=SimpleNamespace(record=record),
        model=SimpleNamespace(robot=load_robot("elbow")),
    )
    texts = warnings._one_way_warnings(findings)
    assert bool(texts) is warned
    assert all(text.startswith("motor_2 moves in one direction only") for text in texts)
