"""The share of a gap that a repair closes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.gap.held_out.closed_share import closed_fraction, share_between
from tests.gap.diagnosis_logs import ROBOT
from tests.gap.held_out.made_errors import ahead, synthetic

FRICTION = "coulomb_friction@motor_1:level=0.05"


@pytest.mark.slow
def test_a_gap_shows_and_the_true_model_closes_it() -> None:
    before, after = ahead((FRICTION,)), ahead((FRICTION,), level=0.05)
    assert before.mean > 20
    assert after.mean == pytest.approx(1.0, abs=0.35)
    share = closed_fraction(before, after, ROBOT.sample_time)
    assert share is not None
    assert share.value == pytest.approx(1.0, abs=0.02)
    assert share.interval[0] <= share.value <= share.interval[1]


def test_what_opens_between_two_repairs_is_a_share_of_the_whole_gap() -> None:
    before, more, less = (synthetic(level, seed) for seed, level in enumerate((11.0, 6.0, 3.5)))
    share = share_between(before, more, less, ROBOT.sample_time)
    assert share is not None
    assert share.value == pytest.approx(0.25, abs=0.06)
    assert share.interval[0] < 0.25 < share.interval[1]


def test_errors_within_the_noise_of_the_floor_have_a_share_of_all_errors_alone() -> None:
    before, less = synthetic(0.9, 0), synthetic(0.45, 1)
    assert share_between(before, before, less, ROBOT.sample_time) is None
    share = share_between(before, before, less, ROBOT.sample_time, floor=0.0)
    assert share is not None
    assert share.value == pytest.approx(0.5, abs=0.06)


def test_closed_share_is_that_of_the_excess_over_the_floor() -> None:
    share = closed_fraction(synthetic(11.0, 0), synthetic(6.0, 1), ROBOT.sample_time)
    assert share is not None
    assert share.value == pytest.approx(0.5, abs=0.06)
    assert share.interval[0] < 0.5 < share.interval[1]
    assert share.interval[1] - share.interval[0] < 0.2


def test_a_repair_with_a_longer_delay_is_predicted_from_a_later_instant_on() -> None:
    before, whole = synthetic(11.0, 0), synthetic(6.0, 1)
    after = replace(whole, squares=whole.squares[7:], starts=whole.starts[7:] - 3)
    share = closed_fraction(before, after, ROBOT.sample_time)
    assert share is not None
    assert share.value == pytest.approx(0.5, abs=0.06)
    assert share.interval[0] < 0.5 < share.interval[1]


def test_a_repair_that_does_nothing_closes_nothing() -> None:
    same = synthetic(11.0)
    share = closed_fraction(same, same, ROBOT.sample_time)
    assert share is not None
    assert share.value == 0.0
    assert share.interval == (0.0, 0.0)


def test_errors_that_do_not_exceed_noise_have_no_share() -> None:
    assert closed_fraction(synthetic(1.0), synthetic(1.0, 1), ROBOT.sample_time) is None


def test_a_gap_in_blocks_that_a_repair_does_not_predict_has_no_share() -> None:
    noise, after = synthetic(1.0, windows=100), synthetic(1.0, 1, windows=100)
    first = noise.starts * ROBOT.sample_time < noise.settings.block
    before = replace(noise, squares=np.where(first[:, None], 100.0, 1.0) * noise.squares)
    later = replace(after, squares=after.squares[~first], starts=after.starts[~first])
    none = replace(after, starts=after.starts + noise.starts[-1] + round(2 * noise.settings.block / ROBOT.sample_time))
    assert closed_fraction(before, after, ROBOT.sample_time) is not None
    assert closed_fraction(before, later, ROBOT.sample_time) is None
    assert closed_fraction(before, none, ROBOT.sample_time) is None
