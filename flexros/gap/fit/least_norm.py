"""Solutions of least norm of symmetric systems, as those of information matrices."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import FloatArray


def least_norm(matrix: FloatArray, right: FloatArray, smallest: float | None = None) -> FloatArray:
    """Solve a symmetric system; directions without information stay zero.

    The singular values of a matrix that is nothing special rarely do not converge (LAPACK gelsd): its eigenvalues do.

    Args:
        matrix: The symmetric matrix, shape (k, k).
        right: Right-hand side, shape (k,) or (k, m).
        smallest: Singular value over the largest one below which a direction has no information [1]; None for rounding.

    Returns:
        The solution, of the shape of the right-hand side.
    """
    try:
        return np.asarray(np.linalg.lstsq(matrix, right, rcond=smallest)[0])
    except np.linalg.LinAlgError:
        rounding = len(matrix) * np.finfo(float).eps
        inverse = np.linalg.pinv(matrix, rcond=rounding if smallest is None else smallest, hermitian=True)
        return np.asarray(inverse @ right, dtype=float)
