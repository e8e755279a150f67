from __future__ import annotations

import math

import pytest

from flexros.compile.command_delay import split_delay, split_delays
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


def test_samples_are_cut_where_any_motor_gets_its_next_command() -> None:
    delays = split_delays((0.2, 0.0, 1.3), 0.5)
    pieces = delays.torque_pieces(3)
    assert [piece.ages for piece in pieces] == [(1, 0, 3), (0, 0, 3), (0, 0, 2)]
    assert [piece.duration for piece in pieces] == pytest.approx([0.2, 0.1, 0.2], abs=1e-15)
    assert delays.line_length == 3


@pytest.mark.parametrize("delay", [0.0, 0.5, 0.7, 1.5])
def test_equal_delays_of_all_motors_are_the_common_delay(delay: float) -> None:
    each, common = split_delays((delay, delay), 0.5), split_delays(delay, 0.5)
    assert each.torque_pieces(2) == common.torque_pieces(2)
    assert each.line_length == common.line_length


def test_impossible_delay_of_one_motor_is_refused() -> None:
    with pytest.raises(InputError, match="command delay -0.1 s is not possible"):
        split_delays((0.0, -0.1), 1e-3)
