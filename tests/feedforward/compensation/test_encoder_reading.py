"""Readings of encoders with periodic errors."""

from __future__ import annotations

import numpy as np

from flexros.effects import parse_effect, place_effects
from flexros.feedforward.compensation.encoder_reading import encoder_reading, position_of_reading
from flexros.robot import Robot


def test_position_of_a_reading_gives_the_reading(e12: Robot) -> None:
    texts = (
        "encoder_eccentricity@motor_2:amplitude=0.01,order=3,phase=0.4",
        "encoder_quantization@motor_2:step=0.1",
    )
    laws = place_effects(e12, [parse_effect(text, "test") for text in texts]).laws
    wanted = np.array([0.7, -1.3])
    position = position_of_reading(e12, laws, wanted)
    assert position[0] == 0.7
    assert abs(position[1] + 1.3) > 1e-3
    read, rate = encoder_reading(e12, laws, 1)(position[1], 2.0)
    np.testing.assert_allclose(float(read), -1.3, rtol=1e-15)
    np.testing.assert_allclose(float(rate), 2.0 * (1 + 0.03 * np.cos(3 * position[1] + 0.4)), rtol=1e-12)
