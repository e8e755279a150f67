"""Arithmetic of truncated Taylor series, for exact derivatives of composed functions.

A series is an array of shape (order + 1, n): row k holds the coefficient f^(k) / k! at each of n samples
(Griewank and Walther 2008, chapter 13).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray


def constant(value: float, like: FloatArray) -> FloatArray:
    """Return the series of a constant, of the same shape as another."""
    result = np.zeros_like(like)
    result[0] = value
    return result


def multiply(a: FloatArray, b: FloatArray) -> FloatArray:
    """Multiply two series."""
    result = np.zeros_like(a)
    for k in range(len(a)):
        for j in range(k + 1):
            result[k] += a[j] * b[k - j]
    return result


def divide(a: FloatArray, b: FloatArray) -> FloatArray:
    """Divide two series; the denominator must not be 0."""
    result = np.zeros_like(a)
    for k in range(len(a)):
        result[k] = (a[k] - sum(result[j] * b[k - j] for j in range(k))) / b[0]
    return result


def root(a: FloatArray) -> FloatArray:
    """Take the square root of a series with a positive value."""
    result = np.zeros_like(a)
    result[0] = np.sqrt(a[0])
    for k in range(1, len(a)):
        result[k] = (a[k] - sum(result[j] * result[k - j] for j in range(1, k))) / (2.0 * result[0])
    return result


def arctan2(y: FloatArray, x: FloatArray) -> FloatArray:
    """Return the angle of two series by integrating (x y' - y x') / (x^2 + y^2)."""
    orders = np.arange(1, len(x))[:, None]
    y_slope, x_slope = np.zeros_like(y), np.zeros_like(x)
    y_slope[:-1], x_slope[:-1] = y[1:] * orders, x[1:] * orders
    slope = divide(multiply(x, y_slope) - multiply(y, x_slope), multiply(x, x) + multiply(y, y))
    result = np.empty_like(x)
    result[0] = np.arctan2(y[0], x[0])
    result[1:] = slope[:-1] / orders
    return result


def compose(coefficients: Sequence[float], a: FloatArray) -> FloatArray:
    """Evaluate a polynomial with ascending coefficients at a series, by Horner's scheme."""
    result = constant(coefficients[-1], a)
    for coefficient in reversed(coefficients[:-1]):
        result = multiply(result, a)
        result[0] += coefficient
    return result
