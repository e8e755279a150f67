"""Covariance of the output error E = Y - G U of one experiment: noise from periods, total from blocks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.identify.frf.estimate.matrix import adjoint
from flexros.identify.frf.estimate.pooling import pooled, windows
from flexros.identify.frf.quantity import differentiation

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray, FloatArray
    from flexros.identify.frf.estimate.matrix import MatrixEstimate
    from flexros.identify.frf.estimate.period_spectra import PeriodSpectra

CONDITION = 1e10
"""Largest condition number of a response that is inverted to refer errors to the input (chosen)."""


@dataclass(frozen=True, eq=False)
class ErrorCovariance:
    """Covariance of the output error of the mean over the periods of one experiment.

    Attributes:
        noise: From the variation over periods, shape (F, n_y, n_y); None with one period.
        total: From the variation over experiments and blocks, shape (F, n_y, n_y); None without spare ones.
        degrees_of_freedom: Complex degrees of freedom of total, of noise where that is None; 0 where both are.
    """

    noise: ComplexArray | None
    total: ComplexArray | None
    degrees_of_freedom: float


def error_covariance(spectra: PeriodSpectra, estimate: MatrixEstimate, order: int, pool_lines: int) -> ErrorCovariance:
    """Estimate the error covariances at the excited lines.

    In closed loop the noise is in U as well as in Y; the unexplained part is E = Y - G U (Pintelon & Schoukens 2012,
    chapter 2), so the covariance of E and not that of Y is estimated. Its covariance C follows from the period means,
    E_hat = Y - G U = E (I - W U), by E[E_hat E_hat^H] = C tr((I - W U)(I - W U)^H).

    The degrees of freedom count neighbouring lines as independent, as noise and stochastic distortion in steady state
    are. A transient that has not decayed is smooth over the lines, so that fewer remain: of 14 for two motors and
    two blocks, repeated simulations of scenario identify_e12 without detection lines show 14 and 15 (motors 1 and 2)
    after 8 transient periods, but 4 and 7 after 2.

    Args:
        spectra: Spectra at the excited lines.
        estimate: The estimate of G from them.
        order: Derivative order of the outputs with respect to position.
        pool_lines: Neighbours on either side over which to pool.
    """
    forms = flattenings(estimate.response, spectra.frequency, order)
    width = windows(len(spectra.lines), pool_lines).shape[1]
    noise, noise_degrees = noise_scatter(spectra, estimate.response), 0.0
    if noise is not None:
        noise_degrees = float(width * spectra.input.shape[0] * (spectra.n_periods - 1))
        following = _following(noise, pool_lines)
        noise = pooled(noise, forms, pool_lines, noise_degrees / width)
        forms = forms if following is None else [*forms, following]
    scatter, degrees = _total_scatter(spectra, estimate)
    if scatter is None:
        return ErrorCovariance(noise, None, noise_degrees)
    return ErrorCovariance(noise, pooled(scatter, forms, pool_lines, degrees), width * degrees)


def noise_scatter(spectra: PeriodSpectra, response: ComplexArray) -> ComplexArray | None:
    """Return the noise covariance of the mean over periods, line by line; None with a single period.

    Periods are treated as independent. At the lowest lines of a robot in closed loop they are not: noise moves the
    axis, and leakage at the end of one period returns at the start of the next, so that the mean is more accurate.

    Args:
        spectra: Spectra at some lines.
        response: G there, shape (L, n_y, n_u).

    Returns:
        Covariance, shape (L, n_y, n_y).
    """
    experiments, periods = spectra.input.shape[:2]
    if periods < 2:
        return None
    error = output_error(spectra, response)
    error = error - error.mean(axis=1, keepdims=True)
    scatter = np.einsum("mpli,mplj->lij", error, np.conj(error))
    return np.asarray(scatter / (experiments * (periods - 1) * periods))


def output_error(spectra: PeriodSpectra, response: ComplexArray) -> ComplexArray:
    """Return Y - G U of every period, shape (m, P, L, n_y).

    Args:
        spectra: Spectra at some lines.
        response: G there, shape (L, n_y, n_u).
    """
    return np.asarray(spectra.output - np.einsum("lij,mplj->mpli", response, spectra.input))


def _total_scatter(spectra: PeriodSpectra, estimate: MatrixEstimate) -> tuple[ComplexArray | None, float]:
    experiments, inputs = spectra.input.shape[0], spectra.input.shape[3]
    if experiments <= inputs:
        return None, 0.0
    U = np.moveaxis(spectra.input.mean(axis=1), 0, 2)
    error = np.moveaxis(output_error(spectra, estimate.response).mean(axis=1), 0, 2)
    rest = np.eye(experiments) - estimate.weights @ U
    square = rest @ adjoint(rest)
    trace = np.einsum("fii->f", square).real
    degrees = trace**2 / np.einsum("fij,fji->f", square, square).real
    scatter = error @ adjoint(error) / trace[:, None, None]
    return scatter, float(np.median(degrees))


def _following(noise: ComplexArray, half: int) -> ComplexArray | None:
    """Return the transformation for errors that are distributed over the lines like the noise between periods."""
    variance = np.einsum("fii->fi", noise).real
    smooth = variance[windows(len(variance), min(half, 1))].mean(axis=1)
    if not np.all(smooth > 0):
        return None
    return np.asarray(np.eye(smooth.shape[1]) / np.sqrt(smooth)[:, :, None], dtype=complex)


def flattenings(response: ComplexArray, frequency: FloatArray, order: int) -> list[ComplexArray]:
    """Return the transformations under which an error may be flat: as position, and referred to the input.

    Args:
        response: G, shape (F, n_y, n_u).
        frequency: Frequencies [Hz], shape (F,).
        order: Derivative order of the outputs with respect to position.

    Returns:
        Stacks of matrices that the error is multiplied by, each of shape (F, n_y, n_y).
    """
    n_y, n_u = response.shape[1:]
    with np.errstate(divide="ignore", invalid="ignore"):
        integration = differentiation(frequency, -order)
    flat = np.where(np.isfinite(integration), integration, 1.0)
    forms: list[ComplexArray] = [np.asarray(flat[:, None, None] * np.eye(n_y), dtype=complex)]
    if n_y == n_u and np.all(np.isfinite(response)) and np.max(np.linalg.cond(response)) < CONDITION:
        forms.append(np.asarray(np.linalg.inv(response), dtype=complex))
    return forms
