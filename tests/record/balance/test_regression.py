"""Least squares of a torque on signals of very different sizes."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.record.balance.regression import coefficients

TIME = np.linspace(0, 5, 500)
SIGNALS = np.column_stack([1e6 * np.sin(TIME), np.sign(np.cos(TIME)), 1e-6 * np.ones_like(TIME)])


def test_factors_of_small_and_large_signals_are_found() -> None:
    true = np.array([3e-6, 2.0, -4e6])
    np.testing.assert_allclose(coefficients(SIGNALS, SIGNALS @ true), true, rtol=1e-9)


def test_signals_that_are_alike_share_the_torque_and_one_that_is_zero_has_none() -> None:
    alike = np.column_stack([TIME, TIME, np.zeros_like(TIME)])
    assert coefficients(alike, 2 * TIME) == pytest.approx([1.0, 1.0, 0.0])
