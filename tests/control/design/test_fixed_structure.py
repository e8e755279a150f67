"""Fixed structures against their transfer functions."""

from __future__ import annotations

import numpy as np

from flexros.control.design.fixed_structure import biquad_system, pid_system

T = 5e-4
FREQUENCY = np.array([0.1, 1.0, 10.0, 100.0, 900.0])


def test_biquad_is_the_bilinear_transform_of_its_transfer_function() -> None:
    wz, dz, wp, dp = 60.0, 0.2, 90.0, 1.5
    s = 2j / T * np.tan(np.pi * FREQUENCY * T)
    expected = ((s / wz) ** 2 + 2 * dz * s / wz + 1) / ((s / wp) ** 2 + 2 * dp * s / wp + 1)
    np.testing.assert_allclose(biquad_system(wz, dz, wp, dp, T).response(FREQUENCY, T)[:, 0, 0], expected, rtol=1e-9)


def test_pid_is_the_transfer_function_of_the_law() -> None:
    kp, ki, kd, tau = 24.0, 100.0, 2.35, 2.6e-3
    z = np.exp(2j * np.pi * FREQUENCY * T)
    expected = kp + ki * T / (1 - 1 / z) + kd * (1 - 1 / z) / (tau + T - tau / z)
    np.testing.assert_allclose(pid_system(kp, ki, kd, tau, T).response(FREQUENCY, T)[:, 0, 0], expected, rtol=1e-9)


def test_series_multiplies_and_parallel_adds_responses() -> None:
    first, second = pid_system(24.0, 100.0, 2.35, 2.6e-3, T), biquad_system(60.0, 0.2, 90.0, 1.5, T)
    one, two = (system.response(FREQUENCY, T)[:, 0, 0] for system in (first, second))
    np.testing.assert_allclose(first.then(second).response(FREQUENCY, T)[:, 0, 0], one * two, rtol=1e-9)
    np.testing.assert_allclose(first.beside(second).response(FREQUENCY, T)[:, 0], np.stack([one, two], -1), rtol=1e-9)
