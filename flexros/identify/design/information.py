"""Information that an experiment in a position gives about the parameters (Moberg 2007, Paper A, eq. 5 and 6)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray, FloatArray


def frf_information(jacobian: ComplexArray, spectrum: ComplexArray, error: FloatArray) -> FloatArray:
    """Compute 2 Re(Psi^H Lambda0^-1 Psi) at each frequency, for an estimate G = Y U^-1 (Paper A, eq. 2, 5 and 6).

    With Y = G U + E and cov(E) = error for each column, the covariance of vec(G) is kron(conj(U U^H)^-1, error). The
    information is then that of the whitened derivative error^-1/2 dG U, which needs no matrix of the size of vec(G).
    The logarithmic estimator with optimal weights (eq. 8) has the same.

    Args:
        jacobian: Derivatives of the FRF with respect to the parameters, shape (..., F, n_y, n_u, P).
        spectrum: U, the inputs of all experiments as columns, shape (..., F, n_u, n_e).
        error: Variance of the output errors of one experiment, uncorrelated, shape (..., F, n_y).

    Returns:
        Information about the parameters, shape (..., F, P, P).
    """
    moved = np.moveaxis(jacobian, -1, -3)  # (..., F, P, n_y, n_u)
    rows = moved.reshape(*moved.shape[:-3], -1, moved.shape[-1]) @ spectrum
    white = rows.reshape(*moved.shape[:-1], -1) / np.sqrt(error)[..., None, :, None]
    flat = white.reshape(*white.shape[:-2], -1)
    both = np.concatenate([flat.real, flat.imag], axis=-1)
    result: FloatArray = 2.0 * both @ np.swapaxes(both, -1, -2)
    return result
