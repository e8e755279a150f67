"""Places in words."""

from __future__ import annotations

import pytest

from flexros.gap.schema import Excess
from flexros.gap.where.words import sentence


@pytest.mark.parametrize(
    ("band", "regime", "words"),
    [
        ((0.0, 4.0), "reversal", "motor_2, below 4 Hz, at reversals: 63 % of the excess"),
        ((0.0, 1000.0), "all", "motor_2: 63 % of the excess"),
        ((125.0, 1000.0), "high torque", "motor_2, above 125 Hz, under high torque: 63 % of the excess"),
        ((4.0, 8.0), "motor angle order 6.00", "motor_2, 4 to 8 Hz, at motor angle order 6.00: 63 % of the excess"),
    ],
)
def test_sentence(band: tuple[float, float], regime: str, words: str) -> None:
    place = Excess(signal="position", joint="motor_2", band_hz=band, regime=regime, share=0.63, p_value=0.01)
    assert sentence(place, 5e-4) == words


def test_sudden_changes_are_called_so() -> None:
    place = Excess(
        signal="sudden position change", joint="motor_1", band_hz=(0, 1000), regime="reversal", share=0.5, p_value=0.01
    )
    assert sentence(place, 5e-4) == "motor_1, at reversals: 50 % of the sudden changes"


def test_lines_of_a_multisine_are_named() -> None:
    place = Excess(
        signal="odd detection lines", joint="motor_1", band_hz=(1, 30), regime="multisine 2", share=0.5, p_value=0.01
    )
    words = "motor_1, 1 to 30 Hz, at multisine 2: 50 % of the excess of the multisines, at odd detection lines"
    assert sentence(place, 5e-4) == words
