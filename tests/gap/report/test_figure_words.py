"""Words for shares, gaps, intervals, p-values and frequency bands."""

from __future__ import annotations

import pytest

from flexros.gap.report.figure_words import (
    band_words,
    closed_words,
    gap_closed_words,
    gap_words,
    p_value_words,
    share_interval_words,
    share_words,
    signed_share_words,
)
from flexros.gap.schema import GapNumbers


def test_bands_without_an_end() -> None:
    assert band_words((0.0, 2.0)) == "below 2 Hz"
    assert band_words((8.0, 20.0)) == "8 to 20 Hz"
    assert band_words((200.0, 1e9)) == "above 200 Hz"
    assert band_words((0.0, 1e9)) == "all frequencies"


def test_shares_are_never_told_as_all_or_nothing_when_they_are_not() -> None:
    assert [share_words(share) for share in (0.0, 1e-6, 0.42, 0.9999, 1.0)] == [
        "0 %",
        "under 1 %",
        "42 %",
        "over 99 %",
        "100 %",
    ]
    assert share_words(1.0 - 1e-16) == "100 %"  # a sum of probabilities
    assert [closed_words(share) for share in (-0.5, 0.83, 0.9968, 1.4)] == ["\u221250 %", "83 %", "99.7 %", "100 %"]
    assert p_value_words(1e-5) == "p < 0.001"


@pytest.mark.parametrize(
    ("after", "words"), [(0.97, "100 %"), (1.9, "100 %"), (12.0, "over 99.9 %"), (900.0, "99.1 %")]
)
def test_not_all_of_a_gap_is_closed_where_floors_are_left(after: float, words: str) -> None:
    closed = (1e5 - after) / (1e5 - 1.0)
    gap = GapNumbers(metric="error", unit="1", before=1e5, after=after, noise_floor=1.0, closed_fraction=closed)
    assert gap_closed_words(gap) == words


def test_a_p_value_that_simulated_logs_resolve_no_better_is_a_bound() -> None:
    assert [p_value_words(count / 201, 200) for count in (1, 2)] == ["p ≤ 0.005", "p = 0.0100"]
    assert p_value_words(1e-5, 200) == "p < 0.001"


def test_shares_of_a_fit_that_strays_are_no_rows_of_digits() -> None:
    assert share_words(4e24) == "over 1000 %"
    assert [signed_share_words(share) for share in (4e24, -4e24, 9.5)] == [
        "over +1000 %",
        "over \u22121000 %",
        "+950 %",
    ]
    assert share_interval_words((1.9e28, 3.5e28)) == ""
    assert share_interval_words((0.5, 4e24)) == " (50 % to over +1000 %)"
    assert share_interval_words((-0.02, 1.2)) == " (\u22122 % to 120 %)"


def test_a_gap_of_predictions_that_ran_away_has_no_size() -> None:
    assert [gap_words(size) for size in (1.234, 51234567.8, 5.3e28)] == ["1.23", "5.12e+07", "divergence"]
