"""The motor gives no more than its limit."""

from __future__ import annotations

import pytest

from tests.effects.single_mass import MASS, SLIDE, T, plant, states


@pytest.mark.parametrize(("force", "given"), [(30.0, 30.0), (80.0, 50.0), (-80.0, -50.0), (-30.0, -30.0)])
def test_torque_is_clipped_at_the_limit(force: float, given: float) -> None:
    path = states(plant("torque_saturation@motor_1:limit=50"), 100, lambda time: force)
    assert path[-1, 1] == pytest.approx(given / MASS * 100 * T, rel=1e-12)


def test_limits_of_the_controller_are_others() -> None:
    limited = plant("torque_saturation@motor_1:limit=50").robot
    assert limited.torque_limits == SLIDE.torque_limits


def test_gain_and_lag_come_behind_the_saturation_whatever_the_order_given() -> None:
    texts = [
        "actuator_lag@motor_1:time_constant=0.02",
        "torque_gain_error@motor_1:relative=0.5",
        "torque_saturation@motor_1:limit=50",
    ]
    paths = [states(plant(*given), 300, lambda time: 80.0) for given in (texts, texts[::-1])]
    momentum = 75.0 * (0.3 - 0.02)  # 1.5 times the limit, late by the time constant
    for path in paths:
        assert MASS * path[-1, 1] == pytest.approx(momentum, rel=1e-6)
