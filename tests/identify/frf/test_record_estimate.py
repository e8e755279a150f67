"""Responses from records that are not periodic."""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

from flexros.identify.frf.experiments import Experiments
from flexros.identify.frf.record_estimate import independent_spacing, record_response, without_line
from flexros.identify.frf.settings import FrfSettings

N, T = 2000, 1e-3


def test_record_from_rest_to_rest_elsewhere_is_exact_without_its_line() -> None:
    """An integrator with lag, moved from one rest to another by a pulse: the ratio of the spectra is the response."""
    u = np.zeros(N)
    u[100:140] = 1.0
    y = lfilter([0.0, 0.02], np.convolve([1.0, -1.0], [1.0, -0.98]), u)
    assert abs(y[-1] - y[0]) > 30
    lines = np.arange(1, 40)
    d = np.exp(-2j * np.pi * lines / N)
    truth = 0.02 * d / ((1 - d) * (1 - 0.98 * d))
    found = np.fft.rfft(without_line(y[:, None])[:, 0])[lines] / np.fft.rfft(u)[lines]
    np.testing.assert_allclose(found, truth, rtol=1e-6)
    assert np.max(abs(np.fft.rfft(y)[lines] / np.fft.rfft(u)[lines] / truth - 1)) > 0.1


def test_ends_are_averaged() -> None:
    ramp = np.linspace(0.0, 1.0, N)[:, None]
    noisy = ramp + 0.1 * np.random.default_rng(0).standard_normal(ramp.shape)
    slopes = [float((noisy - without_line(noisy, rest))[-1, 0]) for rest in (1, 100)]
    assert abs(slopes[1] - 0.95) < 0.03
    assert abs(slopes[1] - 0.95) < abs(slopes[0] - 1.0)


def noise_record(seed: int) -> Experiments:
    rng = np.random.default_rng(seed)
    u = rng.standard_normal(3 * N)
    y = lfilter([1.0, 0.4], [1.0, -1.5, 0.7], u) + 0.05 * rng.standard_normal(3 * N)
    return Experiments.of(u[-N:], y[-N:], T, band=(20.0, 200.0), periodic=False)


def test_lines_kept_are_nearly_independent() -> None:
    """Errors of neighbouring lines hardly correlate; those of all lines do."""

    def correlation(thinned: bool) -> float:
        products, squares = [], []
        for seed in range(10):
            found = record_response(noise_record(seed), FrfSettings(method="local_polynomial", thinned=thinned))
            d = np.exp(-2j * np.pi * found.frequency * T)
            error = found.response[:, 0, 0] - (1 + 0.4 * d) / (1 - 1.5 * d + 0.7 * d**2)
            products.append(np.mean((error[1:] * np.conj(error[:-1])).real))
            squares.append(np.mean(abs(error) ** 2))
        return float(np.mean(products) / np.mean(squares))

    assert correlation(True) < 0.3
    assert correlation(False) > 0.6


def test_spacing_is_the_width_of_the_fit_over_its_gain() -> None:
    assert independent_spacing(5, 2) == 5
    assert independent_spacing(5, 0) == 11


def test_error_is_total_because_noise_cannot_be_told_from_it() -> None:
    found = record_response(noise_record(1), FrfSettings(method="local_polynomial"))
    assert found.total_error is not None
    assert found.noise_error is None
    assert found.degrees_of_freedom > 4
