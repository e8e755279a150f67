from __future__ import annotations

import math

import pytest

from flexros.compile.command_delay import split_delay
from flexros.errors import InputError


@pytest.mark.parametrize(
    ("delay", "ages", "durations", "length"),
    [
        (0.0, [0], [0.5], 0),
        (0.5, [1], [0.5], 1),
        (1.5, [3], [0.5], 3),
        (0.2, [1, 0], [0.2, 0.3], 1),
        (1.3, [3, 2], [0.3, 0.2], 3),
    ],
)
def test_delay_is_split_into_whole_samples_and_a_fraction(
    delay: float, ages: list[int], durations: list[float], length: int
) -> None:
    split = split_delay(delay, 0.5)
    assert [piece.age for piece in split.pieces] == ages
    assert [piece.duration for piece in split.pieces] == pytest.approx(durations, abs=1e-15)
    assert split.line_length == length


def test_whole_samples_and_fraction_add_up_to_the_delay() -> None:
    split = split_delay(1.3, 0.5)
    assert split.whole == 2
    assert (split.whole + split.fraction) * 0.5 == pytest.approx(1.3, rel=1e-15)
    assert split_delay(1.5, 0.5).fraction == 0.0


@pytest.mark.parametrize("samples", [1, 3, 7, 1000])
def test_rounding_of_a_whole_number_of_samples_is_no_fraction(samples: int) -> None:
    for delay in (samples * 1e-3 / 3, math.nextafter(samples * 1e-3 / 3, 1), math.nextafter(samples * 1e-3 / 3, 0)):
        assert split_delay(delay, 1e-3 / 3).line_length == samples
        assert len(split_delay(delay, 1e-3 / 3).pieces) == 1


@pytest.mark.parametrize("delay", [-1e-3, math.nan, math.inf])
def test_impossible_delay_is_refused(delay: float) -> None:
    with pytest.raises(InputError, match="command delay .* s is not possible"):
        split_delay(delay, 1e-3)


@pytest.mark.parametrize("sample_time", [0.0, -1.0, math.nan])
def test_impossible_sample_time_is_refused(sample_time: float) -> None:
    with pytest.raises(InputError, match="sample time .* s is not possible"):
        split_delay(0.0, sample_time)
