"""What limits an answer."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from flexros.effects import parse_effect
from flexros.gap.answer import warnings
from flexros.robot import load_robot


@pytest.mark.parametrize(("sizes", "imported", "warned"), [((-0.48, -0.66), True, True), ((-0.48, -0.1), True, False)])
def test_torques_of_several_motors_that_act_by_other_factors_have_another_unit(
    monkeypatch: pytest.MonkeyPatch, sizes: tuple[float, float], imported: bool, warned: bool
) -> None:
    robot = load_robot("elbow")
    placed = [parse_effect(f"torque_gain_error@motor_{k + 1}:relative={size}", "test") for k, size in enumerate(sizes)]
    monkeypatch.setattr(warnings, "placed_effects", lambda _: placed)
    record = SimpleNamespace(imported=imported)
    findings: Any = SimpleNamespace(
        explanations=SimpleNamespace(chosen=None),
        data=SimpleNamespace(record=record),
        model=SimpleNamespace(robot=robot),
    )
    texts = warnings._unit_warnings(findings)
    assert bool(texts) is warned
    assert all("motor_1: 0.52" in text and "motor_2: 0.34" in text for text in texts)
