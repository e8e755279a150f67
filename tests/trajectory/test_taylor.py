from __future__ import annotations

import math

import numpy as np

from flexros.trajectory import taylor

ORDER = 4
FACTORIALS = np.array([math.factorial(k) for k in range(ORDER + 1)])[:, None]
AT = np.array([0.3, 0.9])


def exponential(rate: float) -> np.ndarray:
    return np.array([rate**k * np.exp(rate * AT) for k in range(ORDER + 1)]) / FACTORIALS


def test_product_of_exponentials() -> None:
    np.testing.assert_allclose(taylor.multiply(exponential(1.0), exponential(2.0)), exponential(3.0), rtol=1e-13)


def test_quotient_of_exponentials() -> None:
    np.testing.assert_allclose(taylor.divide(exponential(1.0), exponential(2.0)), exponential(-1.0), rtol=1e-12)


def test_root_of_an_exponential() -> None:
    np.testing.assert_allclose(taylor.root(exponential(3.0)), exponential(1.5), rtol=1e-13)


def test_angle_of_cosine_and_sine_is_the_argument() -> None:
    cosine = np.array([np.cos(AT + k * np.pi / 2) for k in range(ORDER + 1)]) / FACTORIALS
    sine = np.array([np.sin(AT + k * np.pi / 2) for k in range(ORDER + 1)]) / FACTORIALS
    expected = np.array([AT, np.ones(2), np.zeros(2), np.zeros(2), np.zeros(2)])
    np.testing.assert_allclose(taylor.arctan2(sine, cosine), expected, atol=1e-14)


def test_polynomial_of_an_exponential() -> None:
    expected = 2.0 * exponential(2.0) - exponential(1.0) + taylor.constant(5.0, exponential(1.0))
    np.testing.assert_allclose(taylor.compose([5.0, -1.0, 2.0], exponential(1.0)), expected, rtol=1e-13)
