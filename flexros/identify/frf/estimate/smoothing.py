"""Windows over time and over frequency for non-periodic records."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.identify.frf.estimate.matrix import adjoint

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray, FloatArray, IntArray
    from flexros.identify.frf.settings import DataWindow


@dataclass(frozen=True, eq=False)
class LineEstimate:
    """Response at some lines with the covariance of its residual at a line.

    Attributes:
        response: G, shape (F, n_y, n_u).
        error: Covariance of Y - G U at one line of one experiment, shape (F, n_y, n_y); None without spare degrees.
        input_inverse: Such that cov(vec G) = conj(input_inverse) kron error, shape (F, n_u, n_u).
        degrees_of_freedom: Complex degrees of freedom of each error.
        shared: Correlation between the scatters of two errors 0, 1, 2 ... lines apart, which partly use the same lines,
            shape (K,); zero beyond.
    """

    response: ComplexArray
    error: ComplexArray | None
    input_inverse: ComplexArray
    degrees_of_freedom: float
    shared: FloatArray

    def at(self, rows: IntArray) -> LineEstimate:
        """Return the estimates at some of the lines, by index, shape (K,)."""
        error = None if self.error is None else self.error[rows]
        return replace(self, response=self.response[rows], error=error, input_inverse=self.input_inverse[rows])


def triangular(length: int) -> FloatArray:
    """Return a triangular window without zeros at its ends, of sum 1: 1, 2, 3, 2, 1 over 9 for length 5.

    Args:
        length: Number of weights, odd.

    Raises:
        InputError: The length is even or not positive.
    """
    if length < 1 or length % 2 == 0:
        raise InputError(f"a triangular window of length {length} has no middle; give an odd length, e.g. 5")
    half = (length + 1) // 2
    weight = half - abs(np.arange(length) - half + 1.0)
    return np.asarray(weight / weight.sum())


def data_window(kind: DataWindow, n: int) -> FloatArray:
    """Return weights of the samples of a record, of mean 1.

    Args:
        kind: boxcar, bartlett (triangle over the record) or hann.
        n: Number of samples.
    """
    shapes = {"boxcar": np.ones(n), "bartlett": np.bartlett(n), "hann": np.hanning(n + 1)[:-1]}
    weight = shapes[kind]
    return np.asarray(weight / weight.mean())


def smoothed_estimate(
    inputs: ComplexArray, outputs: ComplexArray, reference: ComplexArray | None, weights: FloatArray
) -> LineEstimate:
    """Estimate G = S_yu S_uu^-1 from spectra smoothed over neighbouring lines; with a reference, S_yr S_ur^-1.

    With the window of length 1 and one experiment this is the ratio (4.5) of Moberg (2007). Smoothing lowers the
    variance and widens narrow peaks: a resonance or antiresonance appears more damped (figure 4.6).

    Args:
        inputs: U at successive lines, shape (F, n_u, m).
        outputs: Y, shape (F, n_y, m).
        reference: R, shape (F, n_u, m), or None.
        weights: Window over lines, odd length, from `triangular`.

    Returns:
        Estimates at all lines; at the ends the window is cut.
    """
    instrument = inputs if reference is None else reference
    _, n_u, m = inputs.shape
    cross, S_u = (_smooth(X @ adjoint(instrument), weights) for X in (outputs, inputs))
    inverse: ComplexArray = np.asarray(np.linalg.inv(S_u), dtype=complex)
    response = cross @ inverse
    power = _smooth(instrument @ adjoint(instrument), weights**2)
    S_yy, S_uy, S_uu = (
        _smooth(left @ adjoint(right), weights)
        for left, right in ((outputs, outputs), (inputs, outputs), (inputs, inputs))
    )
    left_out = response @ S_uy
    rest = S_yy - left_out - adjoint(left_out) + response @ S_uu @ adjoint(response)
    spare = m / np.sum(weights**2) - n_u
    error = None if spare <= 0.5 else rest / (m - n_u * np.sum(weights**2))
    shared = np.correlate(weights, weights, "full")[len(weights) - 1 :] / np.sum(weights**2)
    return LineEstimate(response, error, adjoint(inverse) @ power @ inverse, max(float(spare), 0.0), shared)


def _smooth(spectra: ComplexArray, weights: FloatArray) -> ComplexArray:
    """Weight a stack of matrices over neighbouring lines, shape as given."""
    half = len(weights) // 2
    padded = np.pad(spectra, ((half, half), (0, 0), (0, 0)))
    total = np.zeros_like(spectra)
    for shift, weight in enumerate(weights):
        total += weight * padded[shift : shift + len(spectra)]
    return total
