"""Columns of torques over position: the same law as that of the effects they begin."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from flexros.effects.kinds.motor_law import MotorState
from flexros.effects.torque_curve import TorqueCurve
from flexros.gap.fit.torques.position_torque import PositionTorque


@pytest.mark.parametrize("span", [None, (-0.4, 1.1)])
def test_columns_times_sizes_are_the_torque_of_the_effect(span: tuple[float, float] | None) -> None:
    torque, positions = PositionTorque(0, span), np.linspace(-0.4, 1.1, 31)
    sizes = np.random.default_rng(1).standard_normal(torque.n_sizes)
    fixed = {} if span is None else dict(zip(TorqueCurve.extent, span, strict=True))
    effect = torque.effect(**fixed, **dict(zip(torque.effect.ranges, sizes.tolist(), strict=True)))
    expected = [
        float(ca.DM(effect.added(MotorState(ca.SX(q), ca.SX(0), ca.SX(0), ca.SX(0)), effect.parameter_values)))
        for q in positions.tolist()
    ]
    np.testing.assert_allclose(torque.columns(positions) @ sizes, expected, atol=1e-12)
