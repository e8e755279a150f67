"""Rounding of optimal shares to whole numbers of experiments."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray
    from flexros.identify.design.d_optimal import Design

_NEAR = 200
"""Candidates of largest sensitivity that may enter when a rounded design is improved (chosen)."""
_SINGULAR = 1e-12
"""Smaller eigenvalues than this, relative to the optimal shares, count as no information (chosen)."""
_EXCHANGES = 200
"""Most exchanges (chosen); each raises the determinant, so that they end by themselves."""


def round_design(design: Design, number: int, most: int | None = None) -> IntArray:
    """Round shares to numbers of experiments that keep as much of the information as possible.

    Where there are at least as many experiments as positions with a share, by efficient apportionment (Pukelsheim and
    Rieder 1992); with fewer, the largest shares get one each. Then single experiments are moved to another position
    as long as the determinant grows (Fedorov 1972), where the relaxation says nothing: with few experiments.

    Args:
        design: The shares.
        number: Number of experiments in all.
        most: Most experiments in one position; 1 makes all positions differ, which averages errors of the model that
            the information does not know of. Default: any number.

    Returns:
        Experiments in each candidate, shape (Q,), sum `number`.

    Raises:
        InputError: No experiment, fewer candidates than are wanted, or so few that they cannot determine the
            parameters.
    """
    limit = number if most is None else most
    if number < 1:
        raise InputError(f"{number} experiments were requested, but at least one is needed")
    if limit * len(design.weights) < number:
        raise InputError(
            f"{number} experiments with at most {limit} in each of {len(design.weights)} candidate positions were "
            "requested; draw more candidates or request fewer experiments"
        )
    counts = np.zeros(len(design.weights), dtype=np.int64)
    if number < len(design.support):
        counts[design.support[:number]] = 1
    else:
        counts[design.support] = apportion(design.weights[design.support], number)
    counts = np.minimum(counts, limit)
    for candidate in np.argsort(design.sensitivities)[::-1]:
        counts[candidate] += min(limit - counts[candidate], number - counts.sum())
    return _exchanged(design, counts, limit)


def apportion(weights: FloatArray, number: int) -> IntArray:
    """Apportion experiments efficiently (Pukelsheim and Rieder 1992): no weight's count / share falls behind.

    Args:
        weights: Shares above zero, shape (S,), sum 1.
        number: Number of experiments, at least S.

    Returns:
        Counts, shape (S,), sum `number`, each at least 1.
    """
    counts: IntArray = np.ceil((number - len(weights) / 2) * weights).astype(np.int64)
    while counts.sum() < number:
        counts[np.argmin(counts / weights)] += 1
    while counts.sum() > number:
        counts[np.argmax((counts - 1) / weights)] -= 1
    return counts


def _exchanged(design: Design, counts: IntArray, limit: int) -> IntArray:
    """Move one experiment at a time to where the determinant grows most, until none does."""
    near = np.union1d(design.support, np.argsort(design.sensitivities)[::-1][:_NEAR])
    root = np.linalg.cholesky(design.dual) / np.sqrt(counts.sum())  # makes the unit matrix of the optimal shares
    entering = root.T @ design.information[near] @ root
    total = root.T @ (counts.sum() * design.prior + np.tensordot(counts.astype(float), design.information, 1)) @ root
    value = float(_log_det(total))
    for _ in range(_EXCHANGES):
        best, move = value + 1e-9 if np.isfinite(value) else -np.inf, None
        for leaving in np.flatnonzero(counts):
            without = total - root.T @ design.information[leaving] @ root
            values = np.where(counts[near] < limit, _log_det(without + entering), -np.inf)
            k = int(np.argmax(values))
            if values[k] > best:
                best, move = float(values[k]), (leaving, near[k], without + entering[k])
        if move is None:
            break
        value, (leaving, target, total) = best, move
        counts[leaving] -= 1
        counts[target] += 1
    if np.linalg.eigvalsh(total)[0] < _SINGULAR:
        raise InputError(
            f"{counts.sum()} experiments cannot determine the {len(total)} parameters in any of the positions; "
            "ask for more experiments or give a prior"
        )
    return counts


def _log_det(matrices: FloatArray) -> FloatArray:
    """Return the logarithm of determinants, minus infinity where a matrix is not positive."""
    sign, value = np.linalg.slogdet(matrices)
    return np.where(sign > 0, value, -np.inf)
