"""Frequency response from non-periodic records: chirp, burst, or any other log."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.identify.frf.estimate.covariance import flattenings
from flexros.identify.frf.estimate.local_polynomial import half_width, local_polynomial
from flexros.identify.frf.estimate.period_spectra import check_lines
from flexros.identify.frf.estimate.pooling import pooled, pooled_degrees
from flexros.identify.frf.estimate.smoothing import data_window, smoothed_estimate, triangular
from flexros.identify.frf.quantity import derivative_order

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray, FloatArray, IntArray
    from flexros.identify.frf.estimate.smoothing import LineEstimate
    from flexros.identify.frf.experiments import Experiments
    from flexros.identify.frf.frequency_response import FrequencyResponse
    from flexros.identify.frf.settings import FrfSettings


def without_line(samples: FloatArray, rest_samples: int = 1) -> FloatArray:
    """Subtract the straight line through the two ends of a record.

    For a record from rest to rest this is exact wherever the motion ends: the differences of a sampled signal that
    starts and ends at rest have finite length, so their transform has no leakage, and subtracting a line is the same as
    transforming the differences and dividing by 1 - exp(-j w T_s), at all lines except 0.

    Args:
        samples: One record, shape (N, n).
        rest_samples: Samples at either end over which the first and the last value are averaged.

    Returns:
        The record minus the line, shape (N, n).
    """
    n = len(samples)
    slope = (samples[-rest_samples:].mean(axis=0) - samples[:rest_samples].mean(axis=0)) / n
    return np.asarray(samples - np.arange(n)[:, None] * slope)


def record_response(experiments: Experiments, settings: FrfSettings) -> FrequencyResponse:
    """Estimate the response by local polynomials, or by smoothed spectra where the settings say so.

    Every record is treated as an experiment of its own, with its own transient.

    Args:
        experiments: Samples of the records.
        settings: Settings of the estimation.

    Returns:
        The response, in the quantity of the outputs, at lines whose estimates are nearly independent. Its total error
        is the residual within a record; a noise error cannot be separated from it.
    """
    check_lines(experiments.excited, experiments.period)
    estimate, lines = _line_estimate(experiments, settings)
    frequency = lines / (experiments.period * experiments.sample_time)
    error, degrees = estimate.error, estimate.degrees_of_freedom
    if error is not None:
        forms = flattenings(estimate.response, frequency, derivative_order(experiments.quantity))
        error = pooled(error, forms, settings.pool_lines, degrees)
        degrees = pooled_degrees(degrees, lines, settings.pool_lines, estimate.shared)
    return experiments.response(frequency, estimate.response, estimate.input_inverse, degrees, total_error=error)


def _line_estimate(experiments: Experiments, settings: FrfSettings) -> tuple[LineEstimate, IntArray]:
    """Return the estimate and its lines."""
    m = experiments.inputs.shape[0] * experiments.n_periods
    n_u, smoothing = experiments.inputs.shape[2], settings.method == "smoothing"
    margin = settings.smoothing // 2
    if not smoothing:
        margin = half_width(n_u, m, settings.polynomial_degree, settings.spare_degrees)
    first = max(1, int(experiments.excited[0]) - margin)
    band = np.arange(first, min((experiments.period - 1) // 2, int(experiments.excited[-1]) + margin) + 1)
    known = settings.reference == "auto"
    U, Y, R = (
        None if samples is None else _spectra(samples, experiments, settings, band)
        for samples in (experiments.inputs, experiments.outputs, experiments.reference if known else None)
    )
    assert U is not None
    assert Y is not None
    if smoothing:
        weights = triangular(settings.smoothing)
        every = smoothed_estimate(U, Y, R, weights)
        step = round(1.0 / float(np.sum(weights**2))) if settings.thinned else 1
        lines = experiments.excited[::step]
        return every.at(np.searchsorted(band, lines)), lines
    degree, spare = settings.polynomial_degree, settings.spare_degrees
    step = independent_spacing(margin, degree) if settings.thinned else 1
    lines = experiments.excited[::step]
    return local_polynomial(U, Y, R, np.searchsorted(band, lines), degree, spare), lines


def independent_spacing(half: int, degree: int) -> int:
    """Return the distance in lines of nearly independent local fits: width over variance gain of the centre.

    Args:
        half: Neighbours on either side of a local fit.
        degree: Degree of its polynomials; the centre of a quadratic fit has 9/4 of the variance of a mean.
    """
    return max(1, round((2 * half + 1) / (1.0 if degree < 2 else 2.25)))


def _spectra(samples: FloatArray, experiments: Experiments, settings: FrfSettings, band: IntArray) -> ComplexArray:
    """Transform all records of all experiments, shape (F, n, m P).

    A window that ends in zeros needs no line subtracted, whose slope would depend on the noise of the two ends.
    """
    period, n = experiments.period, samples.shape[2]
    records = samples.reshape(-1, period, n)
    if settings.method == "smoothing" and settings.window != "boxcar":
        weight = data_window(settings.window, period)[:, None]
        parts = [weight * (record - record.mean(axis=0)) for record in records]
    else:
        parts = [without_line(record, settings.rest_samples) for record in records]
    return np.moveaxis(np.array([2.0 / period * np.fft.rfft(part, axis=0)[band] for part in parts]), 0, 2)
