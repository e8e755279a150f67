"""Levels of noise, odd and even nonlinear distortion, and time variation in the output."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.identify.frf.distortion import Distortion
from flexros.identify.frf.estimate.covariance import noise_scatter, output_error
from flexros.identify.frf.estimate.pooling import windows

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray, FloatArray, IntArray
    from flexros.identify.frf.estimate.covariance import ErrorCovariance
    from flexros.identify.frf.estimate.period_spectra import PeriodSpectra


def distortion_levels(
    spectra: PeriodSpectra,
    excited: IntArray,
    odd: IntArray,
    even: IntArray,
    response: ComplexArray,
    error: ErrorCovariance,
    pool_lines: int,
) -> Distortion:
    """Estimate the levels from excited and detection lines (Schoukens, Pintelon, Dobrowiecki & Rolain 2005).

    In closed loop the torque has harmonics at detection lines, too. The response to the torque at these lines, by the
    best linear approximation interpolated between excited lines, is therefore subtracted: E = Y - G U.

    Args:
        spectra: Spectra at the excited and detection lines.
        excited: Excited lines, shape (F,).
        odd: Odd detection lines, shape (D,).
        even: Even detection lines, shape (E,).
        response: Best linear approximation at the excited lines, shape (F, n_y, n_u).
        error: Error covariances there.
        pool_lines: Neighbours on either side over which levels of time variation are pooled.
    """
    at_excited = spectra.at(excited)
    output = _rms(at_excited.output.mean(axis=1))
    unknown = np.full(output.shape, np.nan)
    return Distortion(
        frequency=at_excited.frequency,
        output=output,
        noise=unknown if error.noise is None else _deviation(error.noise),
        total=unknown if error.total is None else _deviation(error.total),
        time_variation=_time_variation(spectra, excited, np.union1d(odd, even), response, pool_lines),
        **_level("odd", spectra, excited, odd, response),
        **_level("even", spectra, excited, even, response),
    )


def interpolated(response: ComplexArray, frequency: FloatArray, at: FloatArray) -> ComplexArray:
    """Interpolate a response linearly between lines; beyond them the nearest value is held.

    Args:
        response: Response, shape (F, n_y, n_u).
        frequency: Its frequencies [Hz], increasing, shape (F,).
        at: Frequencies [Hz] of the result, shape (L,).

    Returns:
        Response, shape (L, n_y, n_u).
    """
    flat = response.reshape(len(response), -1)
    columns = [np.interp(at, frequency, column) for column in flat.T]
    return np.array(columns).T.reshape(len(at), *response.shape[1:])


def _level(
    kind: str, spectra: PeriodSpectra, excited: IntArray, lines: IntArray, response: ComplexArray
) -> dict[str, FloatArray]:
    detection = spectra.at(lines)
    response_there = interpolated(response, spectra.at(excited).frequency, detection.frequency)
    noise = noise_scatter(detection, response_there) if len(lines) else None
    level = _rms(output_error(detection, response_there).mean(axis=1))
    unknown = np.full(level.shape, np.nan)
    return {
        f"{kind}_frequency": detection.frequency,
        kind: level,
        f"{kind}_noise": unknown if noise is None else _deviation(noise),
    }


def _time_variation(
    spectra: PeriodSpectra, excited: IntArray, detection: IntArray, response: ComplexArray, pool_lines: int
) -> FloatArray:
    """Return the change from period to period at excited lines beyond that at neighbouring detection lines.

    Noise is alike at all lines; only time variation increases the variance at excited lines, and only there.
    """
    at_excited, at_detection = spectra.at(excited), spectra.at(detection)
    change = noise_scatter(at_excited, response)
    if change is None or len(detection) < 2:
        return np.full((len(excited), spectra.output.shape[3]), np.nan)
    floor = noise_scatter(at_detection, interpolated(response, at_excited.frequency, at_detection.frequency))
    assert floor is not None
    changes, floors = (_pooled_variance(variance, pool_lines) for variance in (change, floor))
    floors = np.array([np.interp(at_excited.frequency, at_detection.frequency, column) for column in floors.T]).T
    return np.asarray(np.sqrt(np.maximum(changes - floors, 0.0) * spectra.n_periods))


def _pooled_variance(covariance: ComplexArray, half: int) -> FloatArray:
    variance = np.einsum("fii->fi", covariance).real
    return np.asarray(variance[windows(len(variance), half)].mean(axis=1))


def _rms(amplitude: ComplexArray) -> FloatArray:
    """Return the rms over experiments, shape (L, n_y) for (m, L, n_y)."""
    return np.asarray(np.sqrt(np.mean(abs(amplitude) ** 2, axis=0)))


def _deviation(covariance: ComplexArray) -> FloatArray:
    return np.asarray(np.sqrt(np.einsum("fii->fi", covariance).real))
