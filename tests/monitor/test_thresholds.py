"""Thresholds: the rate is that of the whole monitor, and a calibration only raises them."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.effects.patching.patched_robot import load_model
from flexros.monitor.calibration import calibrate
from flexros.monitor.design_book import DesignBook
from flexros.monitor.thresholds import LENGTHS, chances_of, thresholds

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def book() -> DesignBook:
    return DesignBook(load_model("elbow"), 5e-4, 200)


def test_rarer_alarms_and_shorter_windows_have_higher_thresholds(book: DesignBook) -> None:
    often, seldom = (thresholds(book, 200, false_alarms=rate) for rate in (1.0, 1e-3))
    assert np.all(seldom.alarm > often.alarm)
    assert np.all(seldom.alarm > seldom.warning)
    assert np.all(np.diff(seldom.alarm, axis=0) < 0)
    np.testing.assert_allclose(seldom.warning, thresholds(book, 200, false_alarms=0.1).alarm)


def test_false_alarms_come_at_the_rate_that_was_asked_for(book: DesignBook) -> None:
    """Noise through observer model and filter as linear systems, at a rate that can be counted."""
    from flexros.monitor.design import driven_by_noise

    rate = 3000.0
    limit = thresholds(book, 200, false_alarms=rate).alarm
    found = book.at(book.home).design
    system = driven_by_noise(found.pose, found.gain, found.filter)
    windows, runs = 100, 40  # 400 s in all
    rng = np.random.default_rng(7)
    state = np.zeros((len(system.A), runs))
    sums = np.zeros((windows, 4, runs))
    for k in range(-2000, windows * 200):
        noise = book.noise[:, None] * rng.normal(size=(2, runs))
        if k >= 0:
            output = system.C @ state + system.D @ noise
            output /= np.concatenate([found.spread, found.torque_spread])[:, None]
            sums[k // 200, :2] += output[:2] ** 2 / 200
            if k % book.block == book.block - 1:
                sums[k // 200, 2:] += output[2:] ** 2 / (200 // book.block)
        state = system.A @ state + system.B @ noise
    exceeded = 0
    for row, length in enumerate(LENGTHS):
        means = sums.reshape(windows // length, length, 4, runs).mean(axis=1)
        exceeded += int(np.count_nonzero(means > limit[row][:, None]))
    chances = chances_of(4, rate)
    expected = float(sum(4 * runs * windows / length * chance for length, chance in zip(LENGTHS, chances)))
    assert abs(exceeded - expected) < 4 * np.sqrt(expected)


def test_the_chances_of_all_signals_and_lengths_add_up_to_the_rate() -> None:
    each_hour = chances_of(6, 0.001) * 3600 / (0.1 * np.array(LENGTHS))
    assert 6 * each_hour.sum() == pytest.approx(0.001)


def test_a_calibration_raises_thresholds_and_never_lowers_them(book: DesignBook) -> None:
    rng = np.random.default_rng(1)
    values = np.exp(0.2 * rng.normal(size=(600, 4))) * [1.0, 1.0, 50.0, 0.01]
    known = calibrate(values, np.zeros((600, 6)), ("motor_1", "motor_2"), model="x", robot="elbow", log="log")
    plain, raised = (thresholds(book, 200, calibration=one) for one in (None, known))
    assert np.all(raised.alarm[:, 2] > 50)
    np.testing.assert_array_equal(raised.alarm[:, 3], plain.alarm[:, 3])
    assert np.all(raised.alarm >= plain.alarm)
