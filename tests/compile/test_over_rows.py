"""Functions at many samples equal those at each sample to the last bit."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from flexros.compile.over_rows import over_rows


@pytest.fixture(scope="module")
def function() -> ca.Function:
    """Of a vector of three and one of two: a vector, a matrix, and a column."""
    x, p = ca.SX.sym("x", 3), ca.SX.sym("p", 2)
    return ca.Function("f", [x, p], [ca.sin(x) * p[0], ca.jacobian(ca.dot(x, x) * p, x), ca.exp(p)])


@pytest.mark.parametrize(("n", "together"), [(1, 100), (7, 100), (7, 3)])
def test_each_sample_is_as_of_a_call_of_its_own(
    monkeypatch: pytest.MonkeyPatch, function: ca.Function, n: int, together: int
) -> None:
    monkeypatch.setattr("flexros.compile.over_rows.SAMPLES", together)
    rng = np.random.default_rng(0)
    x, p = rng.normal(size=(3, n)).T, rng.normal(size=(n, 2))
    vector, matrix, column = over_rows(function, x, p)
    assert vector.shape == (n, 3)
    assert matrix.shape == (n, 2, 3)
    assert column.shape == (n, 2)
    for k in range(n):
        alone = [part.full() for part in function(x[k], p[k])]
        np.testing.assert_array_equal(vector[k], alone[0][:, 0])
        np.testing.assert_array_equal(matrix[k], alone[1])
        np.testing.assert_array_equal(column[k], alone[2][:, 0])


def test_without_samples_there_is_nothing(function: ca.Function) -> None:
    assert [part.shape for part in over_rows(function, np.zeros((0, 3)), np.zeros((0, 2)))] == [
        (0, 3),
        (0, 2, 3),
        (0, 2),
    ]


def test_arrays_of_another_size_are_not_read(function: ca.Function) -> None:
    with pytest.raises(AssertionError, match="takes"):
        over_rows(function, np.zeros((4, 3)), np.zeros((4, 1)))
    with pytest.raises(AssertionError, match="takes"):
        over_rows(function, np.zeros((4, 3)), np.zeros((3, 2)))
