"""Pooling error covariances over neighbouring lines, so that few blocks give enough degrees of freedom."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.identify.frf.matrix_estimate import adjoint

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import ComplexArray, IntArray


def windows(n_lines: int, half: int) -> IntArray:
    """Return for each line the nearest 2 half + 1 lines (all, where there are fewer), shape (n_lines, width).

    Args:
        n_lines: Number of lines.
        half: Neighbours on either side.
    """
    width = min(2 * half + 1, n_lines)
    first = np.clip(np.arange(n_lines) - half, 0, n_lines - width)
    return np.asarray(first[:, None] + np.arange(width))


def pooled(scatter: ComplexArray, flattenings: Sequence[ComplexArray], half: int) -> ComplexArray:
    """Average covariances over neighbouring lines where they are flattest.

    An error covariance may change fast with frequency: encoder noise is flat in position, while torque disturbances
    and friction are flat referred to the input. Each flattening T is tried, C = T^-1 mean(T S T^H) T^-H, and the one
    whose result explains the scatter best (Gaussian likelihood summed over the lines) is taken.

    Args:
        scatter: Unbiased covariance of each line, shape (F, n, n).
        flattenings: Stacks T, each of shape (F, n, n), at least one.
        half: Neighbours on either side; 0 pools nothing.

    Returns:
        Covariance, shape (F, n, n).
    """
    if half == 0 or len(scatter) == 1:
        return scatter
    places = windows(len(scatter), half)
    candidates = []
    for flattening in flattenings:
        flat = flattening @ scatter @ adjoint(flattening)
        mean = flat[places].mean(axis=1)
        back: ComplexArray = np.asarray(np.linalg.inv(flattening), dtype=complex)
        pooled_scatter = back @ mean @ adjoint(back)
        candidates.append((_misfit(pooled_scatter, scatter), pooled_scatter))
    best: ComplexArray = min(candidates, key=lambda pair: pair[0])[1]
    return best


def _misfit(covariance: ComplexArray, scatter: ComplexArray) -> float:
    """Return the summed log det C + tr(C^-1 S); of the diagonals alone where a covariance is singular."""
    n = covariance.shape[1]
    if n == 1 or np.min(np.linalg.cond(covariance)) > 1e12:
        model = np.einsum("fii->fi", covariance).real
        sample = np.einsum("fii->fi", scatter).real
        model = np.maximum(model, np.finfo(float).tiny)
        return float(np.sum(np.log(model) + sample / model))
    sign, logarithm = np.linalg.slogdet(covariance)
    fit = np.einsum("fii->f", np.linalg.solve(covariance, scatter)).real
    return float(np.sum(np.where(sign.real > 0, logarithm, np.inf) + fit))
