"""Anti-windup gain of a linear controller in state space."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import FloatArray

_FLOOR = 1e-6
"""Smallest noise assumed on the torque, over the largest direct or first gain (chosen)."""
_STABLE = 1.0 - 1e-9
"""Largest eigenvalue of an observer that counts as stable [1]."""


def anti_windup_gain(A: FloatArray, B: FloatArray, C: FloatArray, D: FloatArray) -> FloatArray:
    """Return the gain L with which a controller in its limit observes the torque that acts.

    x+ = A x + B e + L (u - C x - D e): L is the Kalman gain of x+ = A x + B e, u = C x + D e with white inputs e. Where
    the controller is minimum phase, this is L = B D^-1, the conditioning of Hanus et al. (1987); else the observer has
    the mirrored zeros, so that it is stable in any case.

    Args:
        A: Shape (n, n).
        B: Shape (n, n_inputs).
        C: Shape (M, n).
        D: Shape (M, n_inputs).

    Returns:
        L, shape (n, M); zeros where a stable controller has no such gain.
    """
    from scipy.linalg import solve_discrete_are  # loads slowly, and every run would wait for it

    n, motors = len(A), len(D)
    if n == 0:
        return np.zeros((0, motors))
    size = max(float(np.max(np.abs(D))), float(np.max(np.abs(C @ B))), np.finfo(float).tiny)
    noise, cross = D @ D.T + (_FLOOR * size) ** 2 * np.eye(motors), B @ D.T
    power = B @ B.T
    try:
        P = solve_discrete_are(A.T, C.T, power + 1e-12 * np.trace(power) / n * np.eye(n), noise, s=cross)
        gain = np.linalg.solve(C @ P @ C.T + noise, (A @ P @ C.T + cross).T).T
    except (np.linalg.LinAlgError, ValueError):
        return np.zeros((n, motors))
    if np.max(np.abs(np.linalg.eigvals(A - gain @ C))) > _STABLE:
        return np.zeros((n, motors))
    return np.asarray(gain)
