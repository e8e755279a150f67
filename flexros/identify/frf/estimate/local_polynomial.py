"""The local polynomial method: response and transient as polynomials over a few neighbouring lines."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.identify.frf.estimate.matrix import adjoint
from flexros.identify.frf.estimate.smoothing import LineEstimate

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray, FloatArray, IntArray

WORST_CONDITION = 1e12
"""Largest condition number of a local fit with columns scaled to equal size (chosen)."""

ANCHORS = 20
"""Number of fits that are compared with their neighbours to estimate the overlap of residuals (chosen)."""


def local_polynomial(
    inputs: ComplexArray,
    outputs: ComplexArray,
    reference: ComplexArray | None,
    at: IntArray,
    degree: int = 2,
    spare: int = 4,
) -> LineEstimate:
    """Estimate G at chosen lines of records of any kind (Pintelon & Schoukens 2012, chapter 7).

    Near line k the spectra of m experiments follow Y(k + r) = G(k + r) U(k + r) + T(k + r) + E(k + r); G and the
    transients T (one per experiment: leakage and memory of the past) are smooth, so both are polynomials of r.
    In closed loop with a known reference, the same is done from R to [Y; U], and G = G_yr G_ur^-1: noise that the
    controller feeds back into U then causes no bias.

    Args:
        inputs: U at L successive lines, shape (L, n_u, m).
        outputs: Y, shape (L, n_y, m).
        reference: R, shape (L, n_u, m), or None.
        at: Indices among the L lines at which G is estimated, shape (F,).
        degree: Degree of the polynomials.
        spare: Degrees of freedom left for the noise in each fit.

    Returns:
        Estimates at these lines.

    Raises:
        InputError: There are too few lines, or the inputs are insufficiently excited there.
    """
    n_u, m = inputs.shape[1:]
    half = half_width(n_u, m, degree, spare)
    width = 2 * half + 1
    if len(inputs) < width:
        raise InputError(
            f"too short a record: {len(inputs)} lines in the band, the local polynomials need {width}; record longer, "
            "or lower polynomial_degree or spare_degrees"
        )
    source = inputs if reference is None else reference
    response, error, inverse = [], [], []
    degrees = width * m - (degree + 1) * (n_u + m)
    overlap = _Overlap(width, m)
    for index, k in enumerate(at):
        first = int(np.clip(k - half, 0, len(inputs) - width))
        rows = slice(first, first + width)
        pseudo, rest = _fit(source[rows], np.arange(first, first + width) - k, degree)
        U, Y = _unfolded(inputs[rows]), _unfolded(outputs[rows])
        B = pseudo[:, :n_u] if reference is None else pseudo[:, :n_u] @ np.linalg.inv(U @ pseudo[:, :n_u])
        G = Y @ B
        unexplained = (Y - G @ U) @ rest if reference is not None else Y @ rest
        response.append(G)
        error.append(unexplained @ adjoint(unexplained) / degrees)
        inverse.append(adjoint(B) @ B)
        overlap.add(first, rest, anchor=index % max(len(at) // ANCHORS, 1) == 0)
    return LineEstimate(np.array(response), np.array(error), np.array(inverse), float(degrees), overlap.shared)


class _Overlap:
    """Shared scatter of local fits whose lines overlap: tr(P Q) over tr(P), with their residual projections P and Q."""

    def __init__(self, width: int, m: int) -> None:
        self.width, self.m = width, m
        self.anchors: list[tuple[int, ComplexArray]] = []
        self.total, self.count = np.zeros(width), np.zeros(width)

    def add(self, first: int, rest: ComplexArray, anchor: bool) -> None:
        """Add the fit over the lines from `first` on; others are compared with those that are anchors."""
        self.anchors = [anchor_fit for anchor_fit in self.anchors if 0 <= first - anchor_fit[0] < self.width]
        if anchor:
            self.anchors.append((first, rest))
        for before, other in self.anchors:
            apart = (first - before) * self.m
            both = slice(0, self.width * self.m - apart), slice(apart, self.width * self.m)
            self.total[first - before] += float(np.vdot(other[both[1], both[1]], rest[both[0], both[0]]).real)
            self.count[first - before] += 1

    @property
    def shared(self) -> FloatArray:
        """Mean over all pairs with equal distance, relative to a fit with itself; 0 where there is no pair."""
        mean = self.total / np.maximum(self.count, 1)
        return np.asarray(mean / mean[0])


def half_width(n_u: int, m: int, degree: int, spare: int) -> int:
    """Return the number of neighbours on either side that a local fit needs.

    Args:
        n_u: Number of inputs.
        m: Number of experiments.
        degree: Degree of the polynomials.
        spare: Degrees of freedom left for the noise.
    """
    rows = ((degree + 1) * (n_u + m) + spare) / m
    return int(np.ceil((rows - 1) / 2))


def _unfolded(spectra: ComplexArray) -> ComplexArray:
    """Concatenate the lines of all experiments, shape (n, width m) for (width, n, m)."""
    return np.asarray(np.moveaxis(spectra, 1, 0).reshape(spectra.shape[1], -1))


def _fit(source: ComplexArray, offset: IntArray, degree: int) -> tuple[ComplexArray, ComplexArray]:
    """Return the right pseudo-inverse of the regressors and the projection on their residual."""
    width, _, m = source.shape
    powers: FloatArray = (offset / max(np.max(np.abs(offset)), 1))[:, None] ** np.arange(degree + 1)
    transient = np.einsum("ws,em->sewm", powers, np.eye(m)).reshape((degree + 1) * m, width * m)
    through = np.einsum("ws,wum->suwm", powers, source).reshape(-1, width * m)
    regressors = np.vstack([through, transient])
    size = np.linalg.norm(regressors, axis=1)
    if not np.all(size > 0) or np.linalg.cond(regressors / size[:, None]) > WORST_CONDITION:
        raise InputError(
            "no excitation: the inputs cannot be separated from the transients within the lines of a local "
            "polynomial; excite all inputs at more lines of the band, lower polynomial_degree, or set method to "
            "periodic for whole periods"
        )
    pseudo = np.linalg.pinv(regressors / size[:, None]) / size
    return pseudo, np.eye(width * m) - pseudo @ regressors
