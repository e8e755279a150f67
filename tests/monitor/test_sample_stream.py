"""Windows from messages: losses, repeats, rates, stamps off the grid, clocks that jump."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.monitor.sample_stream import SampleStream, Window

T = 5e-4
N = 4000


def messages(n: int = N, step: float = T, start: float = 1.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Stamps, positions that grow by one per sample, torques that are minus that."""
    k = np.arange(n)
    return np.rint((start + k * step) * 1e9).astype(np.int64), k[:, None] * 1.0, -k[:, None] * 1.0


def windows(stream: SampleStream, states: Any, commands: Any) -> list[Window]:
    stream.add_states(*states)
    stream.add_commands(*commands)
    return list(stream.windows())


def stream() -> SampleStream:
    return SampleStream(T, 1)


def test_windows_hold_the_samples_and_their_torques() -> None:
    stamp, y, u = messages()
    found = windows(stream(), (stamp, y), (stamp, u))
    assert len(found) == 19  # the last one is not complete before a message behind it
    assert [window.restarted for window in found] == [True] + 18 * [False]
    np.testing.assert_array_equal(np.concatenate([window.position for window in found]), y[:3800])
    np.testing.assert_array_equal(np.concatenate([window.torque for window in found]), u[:3800])
    assert [window.stamp for window in found] == stamp[:3800:200].tolist()


@pytest.mark.parametrize("chunk", [1, 7, 333])
def test_windows_do_not_depend_on_how_messages_are_cut(chunk: int) -> None:
    stamp, y, u = messages(1500)
    stamp = stamp + np.random.default_rng(1).integers(-40_000, 40_000, 1500)
    whole = windows(stream(), (stamp, y), (stamp, u))
    one, cut = stream(), []
    for i in range(0, 1500, chunk):
        one.add_commands(stamp[i : i + chunk], u[i : i + chunk])
        cut += list(one.windows())
        one.add_states(stamp[i : i + chunk], y[i : i + chunk])
        cut += list(one.windows())
    assert len(cut) == len(whole) == 7
    for a, b in zip(whole, cut):
        assert (a.stamp, a.restarted) == (b.stamp, b.restarted)
        np.testing.assert_array_equal(a.position, b.position)
        np.testing.assert_array_equal(a.torque, b.torque)


def test_single_losses_are_bridged() -> None:
    stamp, y, u = messages(1000)
    kept_y, kept_u = (np.delete(np.arange(1000), lost) for lost in ([250, 251, 600], [255, 601]))
    one = stream()
    found = windows(one, (stamp[kept_y], y[kept_y]), (stamp[kept_u], u[kept_u]))
    assert (one.counts.missing, one.counts.lost_windows) == (3, 0)
    assert not any(window.restarted for window in found[1:])
    np.testing.assert_allclose(np.concatenate([window.torque for window in found]), u[:800])
    np.testing.assert_array_equal(np.flatnonzero(~found[1].measured), [50, 51])


def test_longer_losses_cost_their_window_and_restart() -> None:
    stamp, y, u = messages(1600)
    kept = np.delete(np.arange(1600), range(450, 460))
    one = stream()
    found = windows(one, (stamp, y), (stamp[kept], u[kept]))
    assert one.counts.lost_windows == 1
    assert [(window.stamp - stamp[0]) // 100_000_000 for window in found] == [0, 1, 3, 4, 5, 6]
    assert [window.restarted for window in found] == [True, False, True, False, False, False]


def test_a_long_gap_is_passed_over() -> None:
    stamp, y, u = messages(8000)
    kept = np.delete(np.arange(8000), range(1000, 7000))
    one = stream()
    found = windows(one, (stamp[kept], y[kept]), (stamp[kept], u[kept]))
    assert found[-1].stamp == stamp[7600]
    assert one.counts.lost_windows == 30
    assert sum(window.restarted for window in found) == 2


def test_repeats_late_and_unusable_messages_are_counted_and_left_out() -> None:
    stamp, y, u = messages(1000)
    order = np.r_[0:300, 298, 300:500, 499, 500:1000]
    values = y[order].copy()
    values[700] = np.nan
    one = stream()
    found = windows(one, (stamp[order], values), (stamp, u))
    assert (one.counts.late, one.counts.unusable, one.counts.missing) == (2, 1, 1)
    np.testing.assert_allclose(np.concatenate([window.position for window in found]), y[:800])


def test_stamps_that_jump_back_restart() -> None:
    stamp, y, u = messages(1000)
    one = stream()
    found = windows(
        one, (np.r_[stamp + 50 * 10**9, stamp], np.r_[y, y]), (np.r_[stamp + 50 * 10**9, stamp], np.r_[u, u])
    )
    assert [window.stamp for window in found] == stamp[:800:200].tolist()
    assert one.counts.restarts == 1  # what came before the jump was not complete when the jump was heard
    one = stream()
    found = windows(one, (stamp + 50 * 10**9, y), (stamp + 50 * 10**9, u)) + windows(one, (stamp, y), (stamp, u))
    assert sum(window.restarted for window in found) == one.counts.restarts == 2
    assert len(found) == 8


@pytest.mark.parametrize("topic", ["states", "commands"])
def test_one_stamp_far_ahead_on_one_topic_costs_a_restart(topic: str) -> None:
    stamp, y, u = messages(4000)
    ahead = stamp.copy()
    ahead[1000] += 5 * 10**9
    one = stream()
    found = windows(one, (ahead if topic == "states" else stamp, y), (ahead if topic == "commands" else stamp, u))
    assert len(found) >= 14  # of 19; those that waited when the stamp came are lost
    assert found[-1].stamp >= int(stamp[-1]) - 300_000_000
    assert one.unpaired < 0.2


def test_a_topic_that_is_reset_waits_for_the_other_one() -> None:
    stamp, y, u = messages(1000)
    later = stamp + 50 * 10**9
    one = stream()
    windows(one, (later, y), (later, u))
    assert windows(one, (stamp, y), (later[:0], u[:0])) == []
    assert one.unpaired == pytest.approx(0.4995)
    assert windows(one, (later[:0], y[:0]), (stamp, u))[0].stamp == stamp[0]


@pytest.mark.parametrize(("step", "expected"), [(1e-3, 1e-3), (4e-3, 4e-3), (1.0004e-3, 1e-3), (1 / 1024, 1 / 1024)])
def test_other_rates_are_read_off_the_stamps(step: float, expected: float) -> None:
    stamp, y, u = messages(3000, step)
    one = stream()
    found = windows(one, (stamp, y), (stamp, u))
    assert one.sample_time == pytest.approx(expected, rel=1e-4)
    assert len(found) >= 0.9 * 3000 / one.samples - 1
    assert one.counts.lost_windows == 0


def test_a_clock_that_is_a_little_fast_is_followed() -> None:
    stamp, y, u = messages(40_000, T * (1 + 1e-4))
    one = stream()
    found = windows(one, (stamp, y), (stamp, u))
    assert one.counts.lost_windows == 0
    assert one.counts.missing <= 4  # four samples fewer in 40,000
    assert len(found) >= 198


@pytest.mark.parametrize("step", [1.0, 1e-5])
def test_rates_that_none_can_watch_are_refused(step: float) -> None:
    stamp, y, u = messages(200, step)
    with pytest.raises(InputError, match="allowed are 19 Hz to 21000 Hz"):
        windows(stream(), (stamp, y), (stamp, u))


def test_commands_between_the_states_are_held() -> None:
    stamp, y, _ = messages(1000)
    late = stamp + 200_000  # 0.4 of a sample behind
    u = (np.arange(1000) % 2)[:, None] * 1.0
    found = windows(stream(), (stamp, y), (late, u))
    torque = found[1].torque[:, 0]
    np.testing.assert_allclose(torque[:4], [0.4, 0.6, 0.4, 0.6], atol=1e-6)


def test_commands_at_half_the_rate_are_held() -> None:
    stamp, y, u = messages(1000)
    found = windows(stream(), (stamp, y), (stamp[::2], u[::2]))
    np.testing.assert_allclose(found[1].torque[:4, 0], [-200, -200, -202, -202], atol=1e-6)


def test_a_topic_without_the_other_one_does_not_pile_up() -> None:
    one = stream()
    for second in range(100):
        stamp, y, _ = messages(2000, T, 1.0 + second)
        one.add_states(stamp, y)
        assert list(one.windows()) == []
    assert len(one._states.stamp) <= 21 * 2000


@pytest.mark.parametrize("rate", [20, 50])
def test_a_window_without_any_command_is_lost(rate: int) -> None:
    stamp, y, u = messages(400, 1 / rate)
    n = rate // 10
    kept = np.delete(np.arange(400), range(20 * n, 21 * n))
    one = SampleStream(1 / rate, 1)
    windows(one, (stamp, y), (stamp[kept], u[kept]))
    assert one.counts.lost_windows == 1
