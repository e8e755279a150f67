"""Complex arithmetic of compiled text compared with NumPy."""

from __future__ import annotations

import numpy as np

from tests.identify.graybox.complex_operations import evaluate, numbers


def test_products_and_sums() -> None:
    a, b = numbers(80, 0), numbers(80, 1)
    np.testing.assert_allclose(evaluate(lambda w, x, y: w.mul(x, y), a, b), a * b, rtol=1e-14)
    np.testing.assert_allclose(evaluate(lambda w, x, y: w.add(x, w.negative(y)), a, b), a - b, rtol=1e-14)
    result = evaluate(lambda w, x, y: w.add_product(x, x, y), a, b)
    assert np.max(np.abs(result - a * (1 + b)) / (np.abs(a) * (1 + np.abs(b)))) < 1e-15
    result = evaluate(lambda w, x, y: w.add_scaled(x, y, w.block.number(3.0)), a, b)
    assert np.max(np.abs(result - a - 3 * b) / (np.abs(a) + 3 * np.abs(b))) < 1e-15


def test_inverse() -> None:
    a = numbers(80, 2)
    np.testing.assert_allclose(evaluate(lambda w, x, _: w.inverse(x), a, a), 1 / a, rtol=1e-14)
