"""Linear models over a time in which their input is held."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import FloatArray


def held_input(A: FloatArray, B: FloatArray, time: float) -> tuple[FloatArray, FloatArray]:
    """Return state transitions and input matrices of x' = A x + B u with a constant input (Van Loan 1978).

    Args:
        A: Of one model or several, shape (..., n, n).
        B: Shape (..., n, m).
        time: The time [s].

    Returns:
        Arrays of the same shapes.
    """
    from scipy.linalg import expm  # loads slowly, and every run would wait for it

    n, m = B.shape[-2:]
    whole = np.zeros((*A.shape[:-2], n + m, n + m))
    whole[..., :n, :n], whole[..., :n, n:] = A, B
    whole = expm(whole * time)
    return whole[..., :n, :n], whole[..., :n, n:]
