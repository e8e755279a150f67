from __future__ import annotations

import numpy as np
import pytest

from flexros.report.number_text import number, percent


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (None, "-"),
        (float("nan"), "-"),
        (0.0, "0"),
        (1001.0, "1001"),
        (0.284912, "0.2849"),
        (12.8, "12.80"),
        (3.2e-6, "3.200e-06"),
        (-0.05, "-0.05000"),
        (12345.6, "12346"),
    ],
)
def test_numbers_are_written_with_four_digits(value, text):
    assert number(value) == text


def test_percent_is_cut_where_it_means_nothing():
    assert percent(0.0213) == "2.13"
    assert percent(12.0) == ">1000"
    assert percent(np.inf) == ">1000"
    assert percent(np.nan) == ">1000"
