"""Bounds of quantitative feedback theory in closed form: gains that a controller must not have."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray, FloatArray
    from flexros.control.design.qft_bounds import Specifications


def forbidden_gains(
    plants: ComplexArray, phase: FloatArray, specifications: Specifications, number: int
) -> list[list[tuple[float, float]]]:
    """Return the gains that a controller must not have at one frequency, for every phase.

    With P = p e^(j a) and K = k e^(j f) each specification is a quadratic inequality in k: with c = cos(a + f)

        |1 + P K|^2 = p^2 k^2 + 2 p c k + 1 >= 1 / sensitivity^2, p^2 k^2 / complementary^2, p^2 / compliance^2

    so that the forbidden gains of a plant are an interval each (Chait and Yaniv 1993); the bound is their union.

    Args:
        plants: Responses of the template at this frequency, shape (Q,).
        phase: Phases of the controller [rad], shape (n_phases,).
        specifications: The specifications.
        number: Index of the frequency.

    Returns:
        For every phase, disjoint ascending intervals of forbidden gains.
    """
    p = np.abs(plants)
    needed = [
        (np.zeros_like(p), np.full_like(p, 1.0 / specifications.sensitivity**2)),
        (p**2 / specifications.complementary**2, np.zeros_like(p)),
        (np.zeros_like(p), p**2 / specifications.compliance[number] ** 2),
    ]
    result = []
    for f in phase:
        c = np.cos(np.angle(plants) + f)
        intervals: list[tuple[float, float]] = []
        for of_square, constant in needed:
            for a, b, d in zip(p**2 - of_square, 2 * p * c, 1.0 - constant, strict=True):
                intervals += _negative(float(a), float(b), float(d))
        result.append(_union(intervals))
    return result


def _negative(a: float, b: float, c: float) -> list[tuple[float, float]]:
    """Return where a k^2 + b k + c < 0 for positive k."""
    if a == 0.0:
        if b == 0.0:
            return [(0.0, np.inf)] if c < 0.0 else []
        root = -c / b
        span = (0.0, root) if b > 0.0 else (root, np.inf)
        return [(max(span[0], 0.0), span[1])] if span[1] > 0.0 else []
    discriminant = b * b - 4.0 * a * c
    if discriminant <= 0.0:
        return [] if a > 0.0 else [(0.0, np.inf)]
    low, high = sorted(((-b - np.sqrt(discriminant)) / (2 * a), (-b + np.sqrt(discriminant)) / (2 * a)))
    spans = [(low, high)] if a > 0.0 else [(0.0, low), (high, np.inf)]
    return [(max(begin, 0.0), end) for begin, end in spans if end > 0.0 and end > max(begin, 0.0)]


def _union(intervals: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Merge intervals that overlap."""
    merged: list[tuple[float, float]] = []
    for begin, end in sorted(intervals):
        if merged and begin <= merged[-1][1]:
            merged[-1] = (merged[-1][0], max(merged[-1][1], end))
        else:
            merged.append((begin, end))
    return merged
