from __future__ import annotations

import math

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.trajectory.limits import Limits
from flexros.trajectory.polynomial import NINTH_DEGREE, QUINTIC, ninth_degree, peaks, quintic


def test_ninth_degree_is_that_of_the_smooth_case() -> None:
    t = np.linspace(0.0, 0.8, 41)[:-1]
    s = t / 0.8
    expected = 2 * np.pi * (126 * s**5 - 420 * s**6 + 540 * s**7 - 315 * s**8 + 70 * s**9)
    np.testing.assert_allclose(ninth_degree(2 * np.pi, 0.8).evaluate(t, 0)[0], expected, atol=1e-12)


def test_quintic_is_the_known_polynomial() -> None:
    s = np.linspace(0.0, 1.0, 41)[:-1]
    np.testing.assert_allclose(quintic(3.0, 1.0).evaluate(s, 0)[0], 3 * (10 * s**3 - 15 * s**4 + 6 * s**5), atol=1e-14)


def test_known_peaks() -> None:
    assert peaks(QUINTIC)[:3] == pytest.approx((1.875, 10 / math.sqrt(3), 60.0))
    assert peaks(NINTH_DEGREE)[0] == pytest.approx(630 / 256)


def test_peaks_agree_with_samples() -> None:
    values = ninth_degree(1.0, 1.0).evaluate(np.linspace(0.0, 1.0, 20001))
    assert peaks(NINTH_DEGREE) == pytest.approx(tuple(np.max(np.abs(values[1:]), axis=1)), rel=1e-6)


@pytest.mark.parametrize(
    ("limits", "order"),
    [(Limits(speed=0.5), 1), (Limits(9, 15.0), 2), (Limits(9, 99, jerk=100.0), 3), (Limits(9, 99, 999, 2000.0), 4)],
)
def test_duration_from_limits_just_meets_the_tightest(limits: Limits, order: int) -> None:
    law = ninth_degree(0.3, limits=limits)
    reached = np.max(np.abs(law.evaluate(np.linspace(0.0, law.duration, 20001))), axis=1)[1:]
    assert reached[order - 1] == pytest.approx(limits.values[order - 1], rel=1e-6)
    assert np.all(reached <= np.array(limits.values) * (1 + 1e-9))


def test_quintic_has_three_bounded_derivatives_and_ninth_degree_all() -> None:
    assert quintic(1.0, 1.0).bounded_derivatives == 3
    assert ninth_degree(1.0, 1.0).bounded_derivatives > 4


def test_too_short_duration_names_the_limit_and_the_least_duration() -> None:
    with pytest.raises(
        InputError,
        match=r"duration of the quintic time law is 0.5 s, allowed are at least 1.875 s for the speed limit; len",
    ):
        quintic(1.0, 0.5, Limits(speed=1.0))


def test_neither_duration_nor_limits_is_refused() -> None:
    with pytest.raises(InputError, match="has neither duration nor limits, allowed is a duration in s or at least one"):
        ninth_degree(1.0)


def test_quintic_refuses_a_snap_limit() -> None:
    with pytest.raises(
        InputError, match="snap limit of the quintic .* allowed is none because its jerk jumps .* choose n"
    ):
        quintic(1.0, limits=Limits(snap=100.0))


@pytest.mark.parametrize("distance", [0.0, -1.0, math.nan])
def test_impossible_distance_is_refused(distance: float) -> None:
    with pytest.raises(InputError, match="distance of the move is .* allowed is a finite number above 0"):
        ninth_degree(distance, 1.0)


@pytest.mark.parametrize("duration", [0.0, -1.0, math.nan])
def test_impossible_duration_is_refused(duration: float) -> None:
    with pytest.raises(InputError, match="the duration is .* s, allowed is a finite number above 0"):
        ninth_degree(1.0, duration)
