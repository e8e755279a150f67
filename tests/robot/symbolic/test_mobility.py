"""Accelerations of a rigid arm and their derivatives to the motor torques from one factorisation."""

from __future__ import annotations

import casadi as ca
import numpy as np

from tests.ur5e import ur5e


def test_accelerations_and_mobility_take_fewer_operations_than_the_derivatives_of_articulated_bodies() -> None:
    model = ur5e().model
    inputs = model.forced_acceleration.sx_in()
    found = model.forced_acceleration(*inputs)
    together = model.acceleration_with_mobility
    assert together.n_instructions() < 1.3 * model.forced_acceleration.n_instructions()
    slopes = ca.Function("slopes", inputs, [ca.jacobian(found, inputs[2])])
    values = [np.random.default_rng(1).normal(size=symbol.shape) for symbol in inputs]
    np.testing.assert_allclose(together(*values)[0].full(), model.forced_acceleration(*values).full(), rtol=1e-10)
    np.testing.assert_allclose(together(*values)[1].full(), slopes(*values).full(), rtol=1e-9, atol=1e-12)
