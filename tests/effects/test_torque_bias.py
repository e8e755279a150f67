"""A constant torque at a motor."""

from __future__ import annotations

import pytest

from tests.effects.single_mass import MASS, plant, states


@pytest.mark.parametrize("level", [7.0, -3.0])
def test_motor_is_accelerated_by_the_bias_alone(level: float) -> None:
    path = states(plant(f"torque_bias@motor_1:level={level}", start=(0.2, 0.0)), 500)
    assert path[-1, 0] - 0.2 == pytest.approx(level / MASS * 0.5**2 / 2, rel=1e-12)
