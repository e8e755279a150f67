"""Speeds and accelerations from positions."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.rigid.motion_estimate import (
    _low_pass,
    check_rows,
    decimate,
    decimation,
    edge,
    estimate_motion,
    lowest_cutoff,
)

T = 1e-3


def test_derivatives_of_a_sine() -> None:
    time = np.arange(6000)[:, None] * T
    w = 2 * np.pi * 2
    motion = estimate_motion(np.sin(w * time), T, 100.0)
    inner = slice(200, -200)
    np.testing.assert_allclose(motion.velocity[inner], w * np.cos(w * time)[inner], atol=1e-4 * w)
    np.testing.assert_allclose(motion.acceleration[inner], -(w**2) * np.sin(w * time)[inner], atol=1e-4 * w**2)


def test_motor_that_stands_still_has_no_speed() -> None:
    rng = np.random.default_rng(1)
    time = np.arange(3000) * T
    q = np.column_stack([np.sin(5 * time), 0.3 * np.ones_like(time)]) + 1e-5 * rng.normal(size=(3000, 2))
    motion = estimate_motion(q, T, 50.0)
    assert motion.moving.tolist() == [True, False]
    assert not np.any(motion.velocity[:, 1])
    assert not np.any(motion.acceleration[:, 1])
    assert np.ptp(motion.position[:, 1]) == 0
    assert motion.position[0, 1] == pytest.approx(0.3, abs=1e-5)


def test_motion_above_the_cutoff_is_no_noise() -> None:
    """Also beside a motor at rest whose coarse encoder toggles for a while."""
    rng = np.random.default_rng(2)
    time = np.arange(4000) * T
    fast = 0.03 * np.sin(2 * np.pi * 6 * time) + 0.02 * np.sin(2 * np.pi * 65 * time)
    toggling = 1e-3 * rng.integers(0, 2, len(time)) * (time > 3.3)
    q = np.column_stack([fast + 1e-5 * rng.normal(size=len(time)), toggling])
    assert estimate_motion(q, T, 50.0).moving.tolist() == [True, False]


def test_decimation_leaves_slow_signals_and_their_phase_alone() -> None:
    factor = decimation(T, 50.0)
    assert factor == 20
    time = np.arange(4000) * T
    kept = decimate(np.column_stack([np.sin(9 * time), np.ones_like(time)]), factor)
    at = time[edge(factor) :][: (len(kept) - 1) * factor + 1 : factor]
    np.testing.assert_allclose(kept[:, 0], np.sin(9 * at), atol=3e-3)
    np.testing.assert_allclose(kept[:, 1], 1.0, rtol=1e-12)


def test_decimation_takes_fast_signals_away() -> None:
    time = np.arange(4000) * T
    assert np.abs(decimate(np.sin(2 * np.pi * 45 * time), 20)).max() < 5e-3


@pytest.mark.parametrize("shape", [(), (3,), (2, 3)])
@pytest.mark.parametrize("samples", [40, 1003])
def test_rows_of_a_decimation_are_those_of_the_whole_convolution(samples: int, shape: tuple[int, ...]) -> None:
    factor = 7
    values = np.random.default_rng(2).normal(size=(samples, *shape))
    kept = decimate(values, factor)
    taps = _low_pass(factor)
    if samples < len(taps):
        assert kept.shape == (0, *shape)
        return
    columns = values.reshape(samples, -1).T
    expected = np.stack([np.convolve(column, taps, mode="valid")[::factor] for column in columns], axis=-1)
    np.testing.assert_allclose(kept, expected.reshape(-1, *shape), atol=1e-13)


def test_no_decimation_where_the_cutoff_is_near_the_rate() -> None:
    values = np.arange(10.0)
    assert decimation(1.0, 1.0) == 1
    assert decimate(values, 1) is values
    assert edge(1) == 0


@pytest.mark.parametrize("cutoff", [0.0, 251.0, np.nan])
def test_cutoff_beyond_the_rate(cutoff: float) -> None:
    with pytest.raises(InputError, match="must be above 0 and at most a quarter of the sampling rate of 1000 Hz"):
        estimate_motion(np.zeros((5000, 1)), T, cutoff)


def test_record_shorter_than_its_filter() -> None:
    with pytest.raises(
        InputError, match="the log has 300 samples, but a cut-off of 50 Hz needs at least 800 at 1 kHz; give"
    ):
        estimate_motion(np.zeros((300, 1)), T, 50.0)


@pytest.mark.parametrize("samples", [160, 332, 5000])
def test_the_lowest_cutoff_is_the_lowest_that_a_log_is_long_enough_for(samples: int) -> None:
    slow = 0.04
    cutoff = lowest_cutoff(samples, slow)
    estimate_motion(np.zeros((samples, 1)), slow, cutoff)
    longer = 1 / (slow * (decimation(slow, cutoff) + 1))
    with pytest.raises(InputError, match="needs at least"):
        estimate_motion(np.zeros((samples, 1)), slow, longer)


def test_rate_of_a_wrong_time_unit_is_doubted() -> None:
    message = (
        "needs at least 400000 at 1 MHz; give a longer log or a higher cut-off, or correct the time unit in the map"
    )
    with pytest.raises(InputError, match=message):
        estimate_motion(np.zeros((24841, 1)), 1e-6, 100.0)


def test_too_few_rows_for_a_regression() -> None:
    check_rows(50, 4)
    with pytest.raises(InputError, match="90 samples are left after filtering and decimation, but 60 parameters need"):
        check_rows(90, 60)


def test_every_sample_has_an_equation_for_each_motor() -> None:
    check_rows(90, 60, 2)
    with pytest.raises(InputError, match="90 samples .* need at least 100"):
        check_rows(90, 100, 2)
