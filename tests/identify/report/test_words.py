"""How numbers are written."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.identify.report.words import interval_text, value_text


@pytest.mark.parametrize(
    ("value", "text"),
    [(3075234.0, "3075200"), (2.50000041e9 + 0.5, "2.5000e+09"), (0.012345678, "0.012346"), (150.0, "150")],
)
def test_values_have_no_exponent_where_they_can_do_without(value: float, text: str) -> None:
    assert value_text(value) == text


@pytest.mark.parametrize(
    ("low", "value", "high", "text"),
    [
        (1.0, 2.0, 3.0, "1 to 3"),
        (1e-9, 2.0, 3.0, "below 3"),
        (1.0, 2.0, np.inf, "above 1"),
        (1e-9, 2.0, 1e9, "unknown"),
        (0.0, 2.0, 5.0, "0 to 5"),
        (-1.0, -0.5, 0.5, "-1 to 0.50000"),
    ],
)
def test_ends_that_say_nothing_are_left_out(low: float, value: float, high: float, text: str) -> None:
    assert interval_text(low, value, high) == text
