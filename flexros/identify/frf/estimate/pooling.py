"""Pooling of error covariances over neighbouring lines, for sufficient degrees of freedom with few blocks."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.identify.frf.estimate.matrix import adjoint

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import ComplexArray, FloatArray, IntArray

CLEARLY = 3.0
"""Gain in log-likelihood over the neighbouring lines from which another flattening is chosen (chosen)."""

SINGULAR = -15.0
"""Log det of a matrix of correlations, per dimension, below which it is singular."""


def windows(n_lines: int, half: int) -> IntArray:
    """Return for each line the nearest 2 half + 1 lines (all, where there are fewer), shape (n_lines, width).

    Args:
        n_lines: Number of lines.
        half: Neighbours on either side.
    """
    width = min(2 * half + 1, n_lines)
    first = np.clip(np.arange(n_lines) - half, 0, n_lines - width)
    return np.asarray(first[:, None] + np.arange(width))


def pooled_degrees(degrees: float, lines: IntArray, half: int, shared: FloatArray) -> float:
    """Return the degrees of freedom of a mean over neighbouring covariances, which may partly use the same lines.

    The variance of the mean of w covariances of nu degrees each is 1/w^2 sum_ij r_ij / nu, with the correlation r_ij of
    their scatters.

    Args:
        degrees: Complex degrees of freedom nu of each covariance.
        lines: Lines of the covariances, increasing, shape (F,).
        half: Neighbours on either side over which the mean is taken.
        shared: Correlation r of the scatters 0, 1, 2 ... lines apart, shape (K,), zero beyond; [1] if independent.

    Returns:
        Complex degrees of freedom, the median over the lines.
    """
    neighbours = lines[windows(len(lines), half)]
    apart = np.abs(neighbours[:, :, None] - neighbours[:, None, :])
    correlation = np.append(shared, 0.0)[np.minimum(apart, len(shared))]
    return float(degrees * neighbours.shape[1] ** 2 / np.median(correlation.sum(axis=(1, 2))))


def pooled(scatter: ComplexArray, flattenings: Sequence[ComplexArray], half: int, degrees: float = 1.0) -> ComplexArray:
    """Average covariances over neighbouring lines where they are flattest.

    An error covariance may change fast with frequency: encoder noise is flat in position, torque disturbances and
    friction are flat referred to the input, a transient that has not decayed follows the noise between periods. Each
    flattening T is evaluated, C_k = T_k^-1 mean(T_l S_l T_l^H) T_k^-H over the neighbours l of line k, and each line
    uses the one that explains the neighbouring scatter clearly best (Gaussian likelihood).

    Args:
        scatter: Unbiased covariance of each line, shape (F, n, n).
        flattenings: Stacks T, each of shape (F, n, n), at least one; the first is taken unless another is better by
            `CLEARLY`.
        half: Neighbours on either side; 0 pools nothing.
        degrees: Complex degrees of freedom of each scatter.

    Returns:
        Covariance, shape (F, n, n).
    """
    if half == 0 or len(scatter) == 1:
        return scatter
    neighbours = windows(len(scatter), half)
    covariances, misfits = [], []
    for index, flattening in enumerate(flattenings):
        flat = flattening @ scatter @ adjoint(flattening)
        mean = flat[neighbours].mean(axis=1)
        back: ComplexArray = np.asarray(np.linalg.inv(flattening), dtype=complex)
        covariances.append(back @ mean @ adjoint(back))
        volume = 2.0 * np.log(abs(np.linalg.det(back)))[neighbours].sum(axis=1)
        misfits.append(degrees * (_log_volume(mean) * neighbours.shape[1] + volume) + (CLEARLY if index else 0.0))
    best = np.argmin(misfits, axis=0)
    return np.asarray(np.array(covariances)[best, np.arange(len(scatter))])


def _log_volume(covariance: ComplexArray) -> FloatArray:
    """Return log det of each covariance, of its diagonal where it is singular, shape (F,)."""
    diagonal = np.maximum(np.einsum("fii->fi", covariance).real, np.finfo(float).tiny)
    scale = np.sqrt(diagonal)
    correlation = covariance / (scale[:, :, None] * scale[:, None, :])
    sign, logarithm = np.linalg.slogdet(correlation)
    usable = (sign.real > 0) & (logarithm > SINGULAR * covariance.shape[1])
    return np.asarray(np.log(diagonal).sum(axis=1) + np.where(np.all(usable), logarithm, 0.0))
