"""Responses from records that are not periodic."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.signal import lfilter

from flexros.identify.frf.estimate.nonperiodic import independent_spacing, record_response, without_line
from flexros.identify.frf.experiments import Experiments
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
    response = np.fft.rfft(without_line(y[:, None])[:, 0])[lines] / np.fft.rfft(u)[lines]
    np.testing.assert_allclose(response, truth, rtol=1e-6)
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


@pytest.mark.slow
def test_lines_kept_are_nearly_independent() -> None:
    """Errors of neighbouring lines hardly correlate; those of all lines do."""

    def correlation(thinned: bool) -> float:
        products, squares = [], []
        for seed in range(10):
            response = record_response(noise_record(seed), FrfSettings(method="local_polynomial", thinned=thinned))
            d = np.exp(-2j * np.pi * response.frequency * T)
            error = response.response[:, 0, 0] - (1 + 0.4 * d) / (1 - 1.5 * d + 0.7 * d**2)
            products.append(np.mean((error[1:] * np.conj(error[:-1])).real))
            squares.append(np.mean(abs(error) ** 2))
        return float(np.mean(products) / np.mean(squares))

    assert correlation(True) < 0.3
    assert correlation(False) > 0.6


def test_spacing_is_the_width_of_the_fit_over_its_gain() -> None:
    assert independent_spacing(5, 2) == 5
    assert independent_spacing(5, 0) == 11


@pytest.mark.slow
@pytest.mark.parametrize(
    "choice",
    [
        {"method": "local_polynomial"},
        {"method": "local_polynomial", "thinned": False},
        {"method": "smoothing", "smoothing": 9},
        {"method": "smoothing", "smoothing": 9, "thinned": False},
    ],
)
def test_degrees_of_freedom_are_those_of_the_scatter_over_repeated_records(choice: dict[str, Any]) -> None:
    """Mean squared over variance of the error covariance; without thinning, neighbours share most of their lines."""
    rng, settings = np.random.default_rng(5), FrfSettings(**choice)
    u, errors = rng.standard_normal((1, 600, 1)), []
    for _ in range(100):
        y = u + 0.1 * rng.standard_normal(u.shape)
        response = record_response(Experiments.of(u, y, T, band=(50.0, 130.0), periodic=False), settings)
        assert response.total_error is not None
        errors.append(response.total_error[:, 0, 0].real)
    drawn = np.mean(np.mean(errors, axis=0) ** 2 / np.var(errors, axis=0))
    assert 0.7 < response.degrees_of_freedom / drawn < 1.2


def test_form_in_which_the_error_is_flat_is_found_next_to_a_resonance() -> None:
    """A disturbance of the torque through a resonance of 4 Hz half width: the error follows |G|^2."""
    a, ratios = [1.0, -1.94 * np.cos(0.2 * np.pi), 0.97**2], []
    for seed in range(4):
        rng = np.random.default_rng(seed)
        u, w = rng.standard_normal(3 * N), 0.2 * rng.standard_normal(3 * N)
        experiments = Experiments.of(u[-N:], lfilter([1.0], a, u + w)[-N:], T, band=(60.0, 140.0), periodic=False)
        response = record_response(experiments, FrfSettings(method="local_polynomial", spare_degrees=10))
        assert response.total_error is not None
        G = 1.0 / np.polyval(a[::-1], np.exp(-2j * np.pi * response.frequency * T))
        ratios.append(response.total_error[:, 0, 0].real / abs(G) ** 2 / (0.2**2 * 4 / N))
    assert np.std(np.log(ratios)) < 0.3
    assert abs(np.mean(np.log(ratios))) < 0.2


def test_error_is_total_because_noise_cannot_be_separated_from_it() -> None:
    response = record_response(noise_record(1), FrfSettings(method="local_polynomial"))
    assert response.total_error is not None
    assert response.noise_error is None
    assert response.degrees_of_freedom > 4
