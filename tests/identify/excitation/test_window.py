"""Smooth switching on and off."""

from __future__ import annotations

import numpy as np

from flexros.identify.excitation.window import window


def test_window_rises_stays_and_falls_alike() -> None:
    value, _, _ = window(1000, 100, 1e-3)
    assert value[0] == 0.0
    assert np.all(value[100:901] == 1.0)
    np.testing.assert_allclose(value[1:101], value[:899:-1], atol=1e-15)
    assert np.all(np.diff(value[:101]) > 0.0)


def test_slope_and_area_are_derivative_and_integral() -> None:
    value, slope, area = window(20_000, 4_000, 1e-4)
    np.testing.assert_allclose(np.gradient(value, 1e-4)[1:-1], slope[1:-1], atol=1e-4)
    np.testing.assert_allclose(np.gradient(area, 1e-4)[1:-1], value[1:-1], atol=1e-6)
    assert area[0] == 0.0
    assert area[-1] == np.float64(1.6)  # 2 s less one ramp


def test_ramps_may_meet_in_the_middle() -> None:
    value, _, area = window(200, 100, 1e-2)
    assert np.argmax(value) == 100
    np.testing.assert_allclose(area[-1], 1.0, atol=1e-6)
