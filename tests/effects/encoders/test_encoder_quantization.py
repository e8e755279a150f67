"""Readings on a lattice."""

from __future__ import annotations

import numpy as np
import pytest

from tests.effects.single_mass import plant


@pytest.mark.parametrize(
    ("position", "reading"), [(0.0, 0.0), (0.004, 0.0), (0.006, 0.01), (-0.004, 0.0), (-0.006, -0.01), (0.1234, 0.12)]
)
def test_reading_is_the_nearest_multiple_of_the_step(position: float, reading: float) -> None:
    moving = plant("encoder_quantization@motor_1:step=0.01", start=(position, 0.0))
    assert moving.measure()[0] == pytest.approx(reading, abs=1e-16)
    assert moving.state[0] == position


def test_quantization_comes_behind_the_periodic_error() -> None:
    texts = ["encoder_quantization@motor_1:step=0.01", "encoder_eccentricity@motor_1:amplitude=0.03,order=1"]
    for given in (texts, texts[::-1]):
        reading = plant(*given, start=(0.5, 0.0)).measure()[0]
        assert reading == pytest.approx(0.01 * np.round((0.5 + 0.03 * np.sin(0.5)) / 0.01), abs=1e-15)
