"""Covariance of the output error E = Y - G U of one experiment: of noise from periods, of everything from blocks."""

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
"""Largest condition of a response that is still inverted to refer errors to the input (chosen)."""


@dataclass(frozen=True, eq=False)
class ErrorCovariance:
    """Covariance of the output error of the mean over the periods of one experiment.

    Attributes:
        noise: From the variation over periods, shape (F, n_y, n_y); None with one period.
        total: From the variation over experiments and blocks, shape (F, n_y, n_y); None where none is spare.
        degrees_of_freedom: Complex degrees of freedom of total, of noise where that is None; 0 where both are.
    """

    noise: ComplexArray | None
    total: ComplexArray | None
    degrees_of_freedom: float


def error_covariance(spectra: PeriodSpectra, found: MatrixEstimate, order: int, pool_lines: int) -> ErrorCovariance:
    """Estimate the error covariances at the excited lines.

    In closed loop the noise is in U as well as in Y; what is not explained is E = Y - G U (Pintelon & Schoukens 2012,
    chapter 2), so E and not Y is looked at. Its covariance C follows from the period means, E_hat = Y - G U =
    E (I - W U), by E[E_hat E_hat^H] = C tr((I - W U)(I - W U)^H).

    The degrees of freedom count neighbouring lines as independent, as noise and stochastic distortion in steady state
    are. A transient that has not died out is smooth over the lines, so that fewer are left: of 14 for two motors and
    two blocks, repeated simulations of scenario identify_e12 without detection lines show 14 and 15 (motors 1 and 2)
    after 8 transient periods, but 4 and 7 after 2.

    Args:
        spectra: Spectra at the excited lines.
        found: The estimate of G from them.
        order: How often the outputs are differentiated positions.
        pool_lines: Neighbours on either side over which to pool.
    """
    forms = flattenings(found.response, spectra.frequency, order)
    width = windows(len(spectra.lines), pool_lines).shape[1]
    noise, noise_degrees = noise_scatter(spectra, found.response), 0.0
    if noise is not None:
        noise_degrees = float(width * spectra.input.shape[0] * (spectra.n_periods - 1))
        following = _following(noise, pool_lines)
        noise = pooled(noise, forms, pool_lines, noise_degrees / width)
        forms = forms if following is None else [*forms, following]
    scatter, degrees = _total_scatter(spectra, found)
    if scatter is None:
        return ErrorCovariance(noise, None, noise_degrees)
    return ErrorCovariance(noise, pooled(scatter, forms, pool_lines, degrees), width * degrees)


def noise_scatter(spectra: PeriodSpectra, response: ComplexArray) -> ComplexArray | None:
    """Return the noise covariance of the mean over periods, line by line; None with a single period.

    Periods count as independent. At the lowest lines of a robot in closed loop they are not: noise moves the axis, and
    what leaks at the end of one period comes back at the start of the next, so that the mean is better than this says.

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


def _total_scatter(spectra: PeriodSpectra, found: MatrixEstimate) -> tuple[ComplexArray | None, float]:
    experiments, inputs = spectra.input.shape[0], spectra.input.shape[3]
    if experiments <= inputs:
        return None, 0.0
    U = np.moveaxis(spectra.input.mean(axis=1), 0, 2)
    error = np.moveaxis(output_error(spectra, found.response).mean(axis=1), 0, 2)
    rest = np.eye(experiments) - found.weights @ U
    square = rest @ adjoint(rest)
    trace = np.einsum("fii->f", square).real
    degrees = trace**2 / np.einsum("fij,fji->f", square, square).real
    scatter = error @ adjoint(error) / trace[:, None, None]
    return scatter, float(np.median(degrees))


def _following(noise: ComplexArray, half: int) -> ComplexArray | None:
    """Return the form in which an error that is distributed over the lines as the noise between periods is flat."""
    variance = np.einsum("fii->fi", noise).real
    smooth = variance[windows(len(variance), min(half, 1))].mean(axis=1)
    if not np.all(smooth > 0):
        return None
    return np.asarray(np.eye(smooth.shape[1]) / np.sqrt(smooth)[:, :, None], dtype=complex)


def flattenings(response: ComplexArray, frequency: FloatArray, order: int) -> list[ComplexArray]:
    """Return the forms in which an error may be flat: as position, and referred to the input.

    Args:
        response: G, shape (F, n_y, n_u).
        frequency: Frequencies [Hz], shape (F,).
        order: How often the outputs are differentiated positions.

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
