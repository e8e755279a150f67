"""From stamps to an even grid."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.record.even_grid import even_grid

N = 4000


def stamps(period: float, jitter: float = 0.0, seed: int = 1, n: int = N) -> np.ndarray:
    """Stamps of an even clock with jitter [s] of its own at every sample."""
    rng = np.random.default_rng(seed)
    time = np.arange(n) * period + jitter * rng.uniform(-1, 1, n)
    return (1_000_000_000 + np.rint((time - time[0]) * 1e9)).astype(np.int64)


@pytest.mark.parametrize("rate", [100, 333.33, 1000, 2000, 10_000])
def test_even_stamps_give_their_sample_time_and_every_slot(rate: float) -> None:
    grid = even_grid(stamps(1 / rate), 5e-4, "log: joint_states")
    assert grid.sample_time == pytest.approx(1 / rate, rel=1e-9)
    np.testing.assert_array_equal(grid.numbers, np.arange(N))
    assert np.abs(grid.deviation).max() < 2e-9
    assert grid.warnings == ()


def test_nominal_sample_time_is_taken_exactly() -> None:
    assert even_grid(stamps(5e-4), 5e-4, "x").sample_time == 5e-4


def test_jitter_of_a_third_of_a_sample_does_not_lose_count() -> None:
    grid = even_grid(stamps(1e-3, 0.3e-3), 5e-4, "x")
    assert grid.sample_time == pytest.approx(1e-3, rel=1e-5)
    np.testing.assert_array_equal(grid.numbers, np.arange(N))


def test_lost_messages_leave_their_slots_empty() -> None:
    keep = np.random.default_rng(2).uniform(size=N) > 0.2
    keep[[0, -1]] = True
    keep[1000:1300] = False
    grid = even_grid(stamps(1e-3, 0.05e-3)[keep], 1e-3, "x")
    np.testing.assert_array_equal(grid.numbers, np.flatnonzero(keep))
    place, own = grid.held()
    assert own.sum() == keep.sum()
    assert grid.numbers[place[1100]] == 999 or not keep[999]


def test_pauses_between_experiments_are_empty_slots_however_long() -> None:
    keep = np.arange(N) % 500 < 100
    grid = even_grid(stamps(1e-2, 1e-4)[keep], 1e-2, "x")
    np.testing.assert_array_equal(grid.numbers, np.flatnonzero(keep))
    assert grid.warnings == ()


def test_two_messages_in_one_slot_leave_the_nearer_one() -> None:
    stamp = np.sort(np.append(stamps(1e-3), 1_000_000_000 + 50_200_000))
    grid = even_grid(stamp, 1e-3, "log: joint_states")
    np.testing.assert_array_equal(grid.numbers, np.arange(N))
    assert stamp[grid.rows[50]] == 1_000_000_000 + 50_000_000
    (warning,) = grid.warnings
    assert warning.startswith("log: joint_states: 1 messages, late or repeated,")


def test_stamps_in_bursts_count_as_even_with_a_warning() -> None:
    even = np.arange(N) * 1e-3
    burst = (np.floor(np.arange(N) / 4) * 4e-3 + (np.arange(N) % 4) * 5e-5)[:]
    assert np.all(np.abs(burst - even) < 4e-3)
    grid = even_grid(np.rint(burst * 1e9).astype(np.int64), 1e-3, "log: joint_states")
    np.testing.assert_array_equal(grid.numbers, np.arange(N))
    assert grid.sample_time == pytest.approx(1e-3, rel=1e-3)
    assert "come in bursts" in grid.warnings[0]


@pytest.mark.parametrize(
    ("period", "hint"),
    [(0.1, "record at a higher rate"), (5e-7, "unit of time looks wrong"), (0.5, "factor of a thousand")],
)
def test_rate_of_no_log_is_refused(period: float, hint: str) -> None:
    with pytest.raises(InputError, match=rf"^log: joint_states is stamped every .* 19 Hz to 21000 Hz: .*{hint}"):
        even_grid(stamps(period), 5e-4, "log: joint_states")


def test_mixed_units_are_refused() -> None:
    stamp = stamps(1e-3)
    stamp[N // 2 :] = stamp[N // 2] + (stamp[N // 2 :] - stamp[N // 2]) * 1000
    with pytest.raises(InputError, match="fit no even sampling, .* whether units of time are mixed"):
        even_grid(stamp, 1e-3, "log: joint_states")


def test_few_messages_are_refused() -> None:
    with pytest.raises(InputError, match="^log: joint_states has 10 messages, at least 32 are needed"):
        even_grid(stamps(1e-3, n=10), 1e-3, "log: joint_states")


def test_stamps_of_a_faster_clock_lose_no_sample() -> None:
    """A recorder of 94 Hz that samples a clock of 500 Hz: intervals of 10 and 12 ms."""
    time = 2e-3 * np.rint(np.arange(N) * 10.66e-3 / 2e-3)
    grid = even_grid(np.rint(time * 1e9).astype(np.int64), 2e-3, "x")
    assert grid.irregular
    assert grid.sample_time == pytest.approx(10.66e-3, rel=1e-4)
    np.testing.assert_array_equal(grid.numbers, np.arange(N))
    assert grid.near(np.ones(N, dtype=bool)).all()


def test_holes_between_irregular_stamps_are_seen() -> None:
    time = 2e-3 * np.rint(np.arange(N) * 10.66e-3 / 2e-3)
    keep = np.ones(N, dtype=bool)
    keep[1000:1007] = False
    grid = even_grid(np.rint(time[keep] * 1e9).astype(np.int64), 2e-3, "x")
    assert grid.numbers[-1] == N - 1
    near = grid.near(np.ones(keep.sum(), dtype=bool))
    assert 5 <= np.count_nonzero(~near) <= 7


@pytest.mark.parametrize("rate", [20.0, 50.0])
def test_servo_rates_are_read(rate: float) -> None:
    assert even_grid(stamps(1 / rate), 5e-4, "x").sample_time == pytest.approx(1 / rate)


def test_a_clock_that_was_set_during_the_recording_is_refused() -> None:
    stamp = stamps(2e-3)
    stamp[N // 2 :] += 10**18
    with pytest.raises(InputError, match=r"the stamps jump by 1e\+09 s behind message 2000"):
        even_grid(stamp, 2e-3, "log: joint_states")
