"""Figures 4.5 to 4.9 of Moberg (2007): what a chirp shows of a two-mass axis under speed control."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.identify.frf.estimate.estimate_response import frequency_response_of
from flexros.identify.frf.experiments import Experiments
from flexros.identify.frf.frequency_response import FrequencyResponse
from flexros.identify.frf.settings import FrfSettings
from flexros.identify.frf.two_mass_example import NOISE, SPEED_GAIN, TwoMassAxis, chirp

AT_REST, TOO_EARLY = 30_000, 21_000
"""Samples after which the axis is at rest again, and after which it is not: the chirp ends at 20 s."""
BAND = (1.5, 48.0)


@pytest.fixture(scope="module")
def axis() -> TwoMassAxis:
    return TwoMassAxis.builtin()


@pytest.fixture(scope="module")
def swept(axis: TwoMassAxis) -> tuple[np.ndarray, np.ndarray]:
    """Torque and position without (column 0) and with noise (column 1)."""
    rng = np.random.default_rng(1)
    noise = np.column_stack([np.zeros(AT_REST), NOISE * rng.standard_normal(AT_REST)])
    return axis.closed_loop(chirp(AT_REST, axis.sample_time), noise)


def speed_response(u: np.ndarray, y: np.ndarray, axis: TwoMassAxis, **settings: object) -> FrequencyResponse:
    experiments = Experiments.of(u, y, axis.sample_time, band=BAND, periodic=False)
    chosen = FrfSettings.model_validate({"method": "smoothing", "thinned": False, **settings})
    return frequency_response_of(experiments, chosen).as_quantity("velocity")


def decibels_off(response: FrequencyResponse, axis: TwoMassAxis) -> float:
    """Rms deviation of the magnitude from the sampled model [dB]."""
    truth = axis.sampled_speed_response(response.frequency)
    return float(np.sqrt(np.mean((20 * np.log10(abs(response.response[:, 0, 0] / truth))) ** 2)))


def test_noise_of_the_speed_is_as_large_as_the_speed(swept: tuple[np.ndarray, np.ndarray], axis: TwoMassAxis) -> None:
    """Figure 4.5."""
    speed = np.diff(swept[1], axis=0) / axis.sample_time
    assert np.std(speed[:, 1] - speed[:, 0]) > np.std(speed[:, 0])


def test_chirp_recorded_to_rest_gives_the_response(swept: tuple[np.ndarray, np.ndarray], axis: TwoMassAxis) -> None:
    """Equation 4.5 without noise: no leakage, because the axis is at rest at both ends."""
    u, y = swept
    assert decibels_off(speed_response(u[:, 0], y[:, 0], axis, smoothing=1), axis) < 0.01


def test_triangular_window_smooths_noise(swept: tuple[np.ndarray, np.ndarray], axis: TwoMassAxis) -> None:
    """Figure 4.6: usable with noise, and better with the window of length 5."""
    u, y = swept
    raw, smooth = (decibels_off(speed_response(u[:, 1], y[:, 1], axis, smoothing=n), axis) for n in (1, 5))
    assert smooth < 0.75 * raw
    assert smooth < 2.0


def test_smoothing_fills_the_antiresonance(swept: tuple[np.ndarray, np.ndarray], axis: TwoMassAxis) -> None:
    """Figure 4.6: filtering increases the estimated damping, the more the longer the window."""
    u, y = swept
    depth = [abs(speed_response(u[:, 0], y[:, 0], axis, smoothing=n).response).min() for n in (1, 41, 81)]
    assert depth[0] < depth[1] < depth[2]
    assert depth[2] > 1.01 * depth[0]


def test_measurement_stopped_too_early_leaks(swept: tuple[np.ndarray, np.ndarray], axis: TwoMassAxis) -> None:
    """Figure 4.7: at 21 s the axis still moves; the local polynomial method models what leaks."""
    u, y = (signal[:TOO_EARLY, 0] for signal in swept)
    plain = decibels_off(speed_response(u, y, axis), axis)
    assert plain > 0.2
    assert decibels_off(speed_response(u, y, axis, method="local_polynomial"), axis) < 0.3 * plain


@pytest.mark.parametrize("seed", [1, 2])
def test_noise_alone_gives_minus_the_inverse_controller(axis: TwoMassAxis, seed: int) -> None:
    """Figure 4.8: -20 dB at all frequencies, with a Bartlett window against leakage."""
    noise = NOISE * np.random.default_rng(seed).standard_normal((AT_REST, 1))
    u, y = axis.closed_loop(np.zeros(AT_REST), noise)
    response = speed_response(u[:, 0], y[:, 0], axis, window="bartlett")
    gain = response.response[:, 0, 0]
    assert np.max(abs(20 * np.log10(abs(gain)) + 20)) < 1.5
    assert abs(np.median(gain.real) * SPEED_GAIN + 1) < 0.02
    assert any("minus the inverse of the controller" in warning for warning in response.warnings)
    plain = speed_response(u[:, 0], y[:, 0], axis).response[:, 0, 0]
    assert np.max(abs(20 * np.log10(abs(plain)) + 20)) > 2 * np.max(abs(20 * np.log10(abs(gain)) + 20))


def test_hold_matters_near_the_nyquist_frequency_only(axis: TwoMassAxis) -> None:
    """Figure 4.9: continuous model against the model sampled with a zero-order hold, to 500 Hz."""
    frequency = np.array([10.0, 50.0, 450.0])
    ratio = abs(axis.sampled_speed_response(frequency) / axis.speed_response(frequency))
    difference = abs(20 * np.log10(ratio))
    assert difference[0] < 0.01
    assert difference[1] < 0.1
    assert difference[2] > 5.0


def test_continuous_model_is_that_of_equations_4_9_and_4_10(axis: TwoMassAxis) -> None:
    J_a, J_m, k, d = 6.0, 4.0, 6e4, 30.0
    w_z, w_p = np.sqrt(k / J_a), np.sqrt(k * (J_a + J_m) / (J_a * J_m))
    zeta_z, zeta_p = d / 2 * np.sqrt(1 / (k * J_a)), d / 2 * np.sqrt((J_a + J_m) / (k * J_a * J_m))
    frequency = np.geomspace(0.5, 400, 50)
    s = 2j * np.pi * frequency
    numerator = s**2 / w_z**2 + 2 * zeta_z * s / w_z + 1
    G = numerator / (s**2 * (J_a + J_m) * (s**2 / w_p**2 + 2 * zeta_p * s / w_p + 1))
    np.testing.assert_allclose(axis.speed_response(frequency), s * G, rtol=1e-9)
