"""A step carried out over a record."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from flexros.identify.axis import recursion
from flexros.identify.axis.recursion import Recursion


def step() -> ca.Function:
    s, i, p = ca.SX.sym("s", 2), ca.SX.sym("i", 3), ca.SX.sym("p", 2)
    after = ca.vertcat(p[0] * s[0] + i[0] * i[1], s[0] - p[1] * ca.sin(s[1]) + i[2])
    return ca.Function("step", [s, i, p], [after, ca.vertcat(s[0], s[0] * s[1], i[2] + s[1])])


@pytest.mark.parametrize("compiled", [True, False])
def test_it_is_the_step_again_and_again(compiled: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recursion, "can_compile", lambda: compiled)
    inputs, parameters = np.random.default_rng(3).standard_normal((50, 3)), np.array([0.9, 0.3])
    state, start = np.array([0.2, -0.1]), np.array([0.2, -0.1])
    outputs = Recursion(step()).run(start, inputs, parameters)
    for row, given in zip(outputs, inputs, strict=True):
        state, expected = (value.full().ravel() for value in step()(state, given, parameters))
        np.testing.assert_allclose(row, expected, atol=1e-12)
    np.testing.assert_array_equal(start, [0.2, -0.1])
