"""A function evaluated at many samples by one call."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from flexros.compile.over_samples import FunctionOverSamples
from flexros.errors import InputError


def function() -> ca.Function:
    x, u, p = ca.SX.sym("x", 3), ca.SX.sym("u", 1), ca.SX.sym("p", 2)
    return ca.Function("f", [x, u, p], [ca.vertcat(ca.sin(x[0]) * p[0], x[1] + u * p[1])])


@pytest.mark.parametrize("lanes", [1, 8])
def test_every_sample_and_lane_is_evaluated(lanes: int) -> None:
    random = np.random.default_rng(0)
    x, u, p = (random.normal(size=shape) for shape in ((20, 3, lanes), (20, 1, lanes), (2, lanes)))
    found = FunctionOverSamples(function(), lanes)(x, u, p)
    expected = np.stack([np.sin(x[:, 0]) * p[0], x[:, 1] + u[:, 0] * p[1]], axis=1)
    np.testing.assert_allclose(found, expected, atol=1e-13)


def test_one_command_serves_all_lanes() -> None:
    x, u, p = np.zeros((5, 3, 8)), np.arange(5.0)[:, None, None], np.ones((2, 8))
    np.testing.assert_array_equal(FunctionOverSamples(function(), 8)(x, u, p)[:, 1], np.repeat(u[:, 0], 8, axis=1))


def test_lanes_without_vector_type_are_refused() -> None:
    with pytest.raises(InputError, match="lanes = 3"):
        FunctionOverSamples(function(), 3)
