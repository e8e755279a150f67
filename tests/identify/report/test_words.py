"""Numbers as text."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.identify.report.words import interval_text, known_ends, reach_text, rounded_text, true_text, value_text


@pytest.mark.parametrize(
    ("value", "text"),
    [(3075234.0, "3075200"), (2.50000041e9 + 0.5, "2.5000e+09"), (0.012345678, "0.012346"), (150.0, "150")],
)
def test_values_have_no_exponent_where_they_can_do_without(value: float, text: str) -> None:
    assert value_text(value) == text


@pytest.mark.parametrize(
    ("low", "value", "high", "text"),
    [
        (1.9, 2.0, 2.1, "1.90 to 2.10"),
        (1e-9, 2.0, 3.0, "below 3"),
        (1.0, 2.0, np.inf, "above 1"),
        (1e-9, 2.0, 1e9, "unknown"),
        (0.0, 2.0, 5.0, "0 to 5"),
        (-1.0, -0.5, 0.5, "-1 to 0.500"),
        (2499013.7, 2499496.0, 2499981.2, "2499010 to 2499980"),
        (1.2304e-7, 1.2345e-7, 1.2386e-7, "1.2304e-07 to 1.2386e-07"),
    ],
)
def test_ends_that_say_nothing_are_left_out(low: float, value: float, high: float, text: str) -> None:
    assert interval_text(low, value, high) == text


@pytest.mark.parametrize(
    ("value", "half", "text"),
    [
        (2499496.0, 486.0, "2499500"),
        (99995.83, 8.6, "99995.8"),
        (50.0571, 0.8, "50.06"),
        (27.629, 8.4, "27.6"),
        (50.0571, np.inf, "50.1"),
        (3.000041234567e9, 2e4, "3.000041e+09"),
    ],
)
def test_values_are_written_to_two_digits_of_their_uncertainty(value: float, half: float, text: str) -> None:
    assert rounded_text(value, value - half, value + half) == text


@pytest.mark.parametrize(
    ("low", "value", "high", "text"),
    [
        (49.264, 50.057, 50.863, "±1.6 %"),
        (20.45, 27.629, 37.329, "-26 +35 %"),
        (119976.0, 120002.0, 120029.0, "±0.022 %"),
        (5.0 / 370.0, 5.0, 5.0 * 370.0, "factor 370"),
        (2.1, 3.0, np.inf, "above 2.10"),
        (-1.0, -0.5, 0.5, "-1 to 0.500"),
    ],
)
def test_reach_of_an_interval_is_told_in_per_cent(low: float, value: float, high: float, text: str) -> None:
    assert reach_text(low, value, high) == text


@pytest.mark.parametrize(
    ("interval", "ends"),
    [
        ((5.8e-155, 1.0, 1.7e156), (None, None)),
        ((0.5, 1.0, np.inf), (0.5, None)),
        ((1e-9, 1.0, 2.0), (None, 2.0)),
        ((-1959.0, 0.5, 1960.0), (None, None)),
        ((-1.0, 0.5, 2.0), (-1.0, 2.0)),
        ((-3.0, -1.0, 1.0), (-3.0, 1.0)),
    ],
)
def test_ends_that_say_nothing_are_none(interval: tuple[float, ...], ends: tuple[float | None, ...]) -> None:
    low, value, high = interval
    assert known_ends(low, value, high) == ends
    if ends == (None, None):
        assert interval_text(low, value, high) == "unknown"


def test_true_values_have_the_digits_of_the_identified_ones() -> None:
    assert true_text(120000.0, 119976.0, 120029.0) == "120000"
    assert true_text(61.23456, 60.4, 62.1) == "61.23"
