"""Torques that an answer leaves, where errors of predicted positions do not show them."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexros.gap.answer.unexplained_torques import hidden_from_torques, torque_warnings, unexplained_torques


def findings(left: tuple[float, float], noise: float | None = None, *, detected: bool = True) -> Any:
    """Findings of a log whose torques change by 1 and 2 Nm, of which an answer usually leaves so much [Nm]."""
    torque = np.tile([[1.0, 2.0], [-1.0, -2.0]], (50, 1))
    torques = SimpleNamespace(torque=torque, usual=lambda _predictor, _theta: np.array(left))
    record = SimpleNamespace(torque_noise=None if noise is None else np.array([noise, noise]))
    chosen = SimpleNamespace(predictor=None, theta=None)
    return SimpleNamespace(
        data=SimpleNamespace(torques=torques, record=record),
        explanations=SimpleNamespace(chosen=chosen, detected=detected),
        model=SimpleNamespace(robot=SimpleNamespace(joint_names=("motor_1", "motor_2"))),
    )


@pytest.mark.parametrize(("left", "noise", "expected"), [
    ((0.2, 1.8), None, {"motor_2": 0.9}),
    ((0.2, 0.6), None, {}),
    ((0.2, 1.8), 2.0, {}),
])  # fmt: skip
def test_a_torque_most_of_which_is_left_is_not_explained(
    left: tuple[float, float], noise: float | None, expected: dict[str, float]
) -> None:
    """A cable at a wrist made all of its torque; a motor that does nothing has noise alone."""
    assert unexplained_torques(findings(left, noise)) == pytest.approx(expected)


def test_the_torques_are_stated() -> None:
    (text,) = torque_warnings(findings((0.2, 1.8)))
    assert "motor_2: 90%" in text
    assert torque_warnings(findings((0.2, 0.6))) == []


def test_where_nothing_was_found_nothing_is_said_of_torques() -> None:
    assert torque_warnings(findings((0.2, 1.8), detected=False)) == []
    without = findings((0.2, 1.8))
    without.data.torques = None
    assert torque_warnings(without) == []


def test_torques_that_are_explained_confirm_an_inertia_that_is_far_larger() -> None:
    both = ("motor_1", "motor_2")
    assert hidden_from_torques(both, findings((0.2, 1.8))) == ("motor_2",)
    without = findings((0.2, 1.8))
    without.data.torques = None
    assert hidden_from_torques(both, without) == both
