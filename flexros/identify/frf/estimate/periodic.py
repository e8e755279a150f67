"""Frequency response from whole periods in steady state: no leakage; noise and distortion are separated."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.identify.frf.estimate.covariance import error_covariance
from flexros.identify.frf.estimate.distortion_levels import distortion_levels
from flexros.identify.frf.estimate.drift import without_drift
from flexros.identify.frf.estimate.matrix import estimate
from flexros.identify.frf.estimate.period_spectra import PeriodSpectra, amplitudes, check_lines
from flexros.identify.frf.quantity import derivative_order

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray, FloatArray, IntArray
    from flexros.identify.frf.experiments import Experiments
    from flexros.identify.frf.frequency_response import FrequencyResponse
    from flexros.identify.frf.settings import FrfSettings


def spectra_of(experiments: Experiments, settings: FrfSettings) -> PeriodSpectra:
    """Transform the periods of all experiments, without the drift of a slow motion.

    Args:
        experiments: Samples of whole periods.
        settings: Settings of the estimation.

    Returns:
        Spectra at the excited and detection lines.
    """
    check_lines(experiments.excited, experiments.period)
    lines = np.unique(np.concatenate([experiments.excited, experiments.odd_detection, experiments.even_detection]))

    def transform(samples: FloatArray) -> ComplexArray:
        return np.array(
            [_transform(samples[i], experiments, settings.drift_degree, lines) for i in range(len(samples))]
        )

    known = experiments.reference is not None and settings.reference == "auto"
    return PeriodSpectra(
        lines=lines,
        period=experiments.period,
        sample_time=experiments.sample_time,
        input=transform(experiments.inputs),
        output=transform(experiments.outputs),
        reference=transform(experiments.reference) if known and experiments.reference is not None else None,
        block=experiments.block,
    )


def _transform(samples: FloatArray, experiments: Experiments, degree: int, lines: IntArray) -> ComplexArray:
    steady = without_drift(samples, experiments.n_periods, degree, experiments.excited)
    return amplitudes(steady, experiments.n_periods, lines)


def periodic_response(
    experiments: Experiments, settings: FrfSettings, spectra: PeriodSpectra | None = None
) -> FrequencyResponse:
    """Estimate the response; U and Y are averaged over periods before they are divided (errors in variables).

    Args:
        experiments: Samples of whole periods.
        settings: Settings of the estimation.
        spectra: Result of `spectra_of`; default: computed here.

    Returns:
        The response, in the quantity of the outputs.
    """
    spectra = spectra_of(experiments, settings) if spectra is None else spectra
    excited = spectra.at(experiments.excited)
    U, Y, R = (
        None if part is None else np.moveaxis(part.mean(axis=1), 0, 2)
        for part in (excited.input, excited.output, excited.reference)
    )
    assert U is not None
    assert Y is not None
    result = estimate(U, Y, R, excited.block, settings.average, excited.frequency)
    error = error_covariance(excited, result, derivative_order(experiments.quantity), settings.pool_lines)
    levels = distortion_levels(
        spectra,
        experiments.excited,
        experiments.odd_detection,
        experiments.even_detection,
        result.response,
        error,
        settings.pool_lines,
    )
    return experiments.response(
        excited.frequency,
        result.response,
        result.input_inverse,
        error.degrees_of_freedom,
        noise_error=error.noise,
        total_error=error.total,
        distortion=levels,
    )
