"""Order spectra."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.gap.where.views.order_spectrum import OrderGrid, prominence


def turning(seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Return angle and speed of a rotor that swings over about ten turns."""
    time = 1e-3 * np.arange(20000)
    return 30 * np.sin(2 * np.pi * 0.13 * time), 30 * 2 * np.pi * 0.13 * np.cos(2 * np.pi * 0.13 * time)


def test_order_and_energy_of_a_harmonic() -> None:
    angle, speed = turning()
    grid = OrderGrid.of(angle, speed, np.ones(20000, dtype=bool), 40.0)
    power = grid.power(np.sin(7.4 * angle + 1))
    total = power.sum(axis=0)
    top = int(total.argmax())
    moving = np.abs(speed) > 0.15 * np.abs(speed).max()
    assert grid.peak_order(top, total[top - 1 : top + 2]) == pytest.approx(7.4, abs=0.05)
    assert total[top] == pytest.approx(10000 * moving.mean(), rel=0.3)


def test_errors_that_repeat_in_time_are_not_prominent() -> None:
    angle, speed = turning()
    noise = np.random.default_rng(1).standard_normal(20000)
    time = 1e-3 * np.arange(20000)
    grid = OrderGrid.of(angle, speed, np.ones(20000, dtype=bool), 40.0)
    harmonic = prominence(grid.power(noise + np.sin(7.4 * angle))).max()
    hum = prominence(grid.power(noise + np.sin(2 * np.pi * 20 * time))).max()
    assert harmonic > 1.5 * hum


def test_drawn_noise_has_the_power_of_transformed_noise() -> None:
    angle, speed = turning()
    grid = OrderGrid.of(angle, speed, np.ones(20000, dtype=bool), 40.0)
    drawn = np.mean([grid.noise(np.random.default_rng(seed)).mean() for seed in range(20)])
    found = np.mean([grid.power(np.random.default_rng(seed).standard_normal(20000)).mean() for seed in range(20)])
    assert drawn == pytest.approx(found, rel=0.1)


def test_a_rotor_that_hardly_turns_has_no_orders() -> None:
    angle, speed = turning()
    assert len(OrderGrid.of(1e-3 * angle, speed, np.ones(20000, dtype=bool), 40.0).orders) == 0
    assert len(OrderGrid.of(angle, 0 * speed, np.ones(20000, dtype=bool), 40.0).orders) == 0
