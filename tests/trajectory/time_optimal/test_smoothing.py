from __future__ import annotations

import numpy as np
import pytest

from flexros.arrays import FloatArray
from flexros.trajectory.time_law import TimeLaw
from flexros.trajectory.time_optimal.profile import FastestProfile, fastest_profile
from flexros.trajectory.time_optimal.smoothing import reversed_way, slowed, smoothed_law
from tests.trajectory.time_optimal.test_profile import carriage

EXTENT, SMOOTHING = 0.4, 0.2


@pytest.fixture
def profile() -> FastestProfile:
    return fastest_profile(carriage(points=101, weight=5.0))


@pytest.fixture
def law(profile: FastestProfile) -> TimeLaw:
    return smoothed_law(profile, SMOOTHING, EXTENT)


def position(profile: FastestProfile, t: FloatArray) -> FloatArray:
    """Return the share of the path of the profile itself at times."""
    time = profile.time
    piece = np.clip(np.searchsorted(time, t, side="right") - 1, 0, time.size - 2)
    since = np.clip(t, 0.0, time[-1]) - time[piece]
    share = profile.grid[piece] + np.sqrt(profile.squared_pace[piece]) * since
    return np.where(t < 0.0, 0.0, share + 0.5 * profile.acceleration[piece] * since**2)


def test_it_is_the_moving_average_taken_twice(profile: FastestProfile, law: TimeLaw) -> None:
    at, half = np.array([0.1, 0.5, 0.9, 1.2]), 0.5 * SMOOTHING
    offset = np.linspace(0.0, SMOOTHING, 20001)
    weight = np.minimum(offset, SMOOTHING - offset) / half**2
    mean = [np.trapezoid(weight * position(profile, t - offset), offset) for t in at]
    np.testing.assert_allclose(law.evaluate(at, 0)[0], EXTENT * np.array(mean), atol=1e-8)


def test_it_goes_from_rest_to_rest_and_never_back(profile: FastestProfile, law: TimeLaw) -> None:
    assert law.duration == pytest.approx(profile.duration + SMOOTHING)
    ends = law.evaluate(np.array([0.0, np.nextafter(law.duration, 0.0)]), 3)
    np.testing.assert_allclose(ends[0], [0.0, EXTENT], atol=1e-14)
    np.testing.assert_allclose(ends[1:], 0.0, atol=1e-9)
    assert law.evaluate(np.linspace(0.0, law.duration, 5001), 1)[1].min() > -1e-12


def test_pieces_join_up_to_the_third_derivative(law: TimeLaw) -> None:
    right = law.evaluate(law.knots[1:-1], 3)
    left = law.evaluate(np.nextafter(law.knots[1:-1], 0.0), 3)
    scale = np.abs(right).max(axis=1)[:, None]
    np.testing.assert_allclose(left / scale, right / scale, atol=1e-9)


def test_jerk_is_a_step_of_the_acceleration_over_half_the_time(profile: FastestProfile, law: TimeLaw) -> None:
    step = np.ptp(profile.acceleration)
    jerk = np.abs(law.evaluate(np.linspace(0.0, law.duration, 5001), 3)[3]).max()
    bound = EXTENT * step / (0.5 * SMOOTHING)
    assert 0.95 * bound < jerk < 1.0001 * bound


def test_slower_law_has_the_same_way_in_more_time(law: TimeLaw) -> None:
    at = np.linspace(0.0, law.duration, 50)
    slow = slowed(law, 2.0).evaluate(2.0 * at, 2)
    np.testing.assert_allclose(slow * np.array([1.0, 2.0, 4.0])[:, None], law.evaluate(at, 2), atol=1e-12)


def test_reversed_way_begins_at_the_end(law: TimeLaw) -> None:
    at = np.linspace(0.0, law.duration, 50)
    np.testing.assert_allclose(reversed_way(law).evaluate(at, 1)[0], EXTENT - law.evaluate(at, 1)[0], atol=1e-14)
