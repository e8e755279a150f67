from __future__ import annotations

import numpy as np

from flexros.report.grid import digits, menu, panels


def test_panels_share_a_logarithmic_frequency() -> None:
    figure = panels(2, 3, [f"panel {index}" for index in range(6)], height=100)
    axes = [figure.layout[name] for name in figure.layout if name.startswith("xaxis")]
    assert len(axes) == 6
    assert {axis.type for axis in axes} == {"log"}
    assert [note.text for note in figure.layout.annotations] == [f"panel {index}" for index in range(6)]


def test_digits_are_significant_and_other_values_none() -> None:
    assert digits(np.array([1.23456, 1.23456e-7, np.nan, np.inf])) == [1.235, 1.235e-7, None, None]


def test_menu_is_placed_along_the_picture() -> None:
    entry = {"label": "position 1", "method": "update", "args": []}
    assert menu([entry], x=0.5)["buttons"] == [entry]
    assert menu([entry], x=0.5)["x"] == 0.5
