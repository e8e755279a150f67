from __future__ import annotations

import numpy as np
import pytest

from flexros.report.decimate import screen_samples


def test_a_short_series_is_kept_whole():
    np.testing.assert_array_equal(screen_samples(np.arange(10.0), 10), np.arange(10))


@pytest.mark.parametrize("n", [3001, 80_000, 100_003])
def test_peaks_survive_and_the_limit_holds(n):
    rng = np.random.default_rng(n)
    values = np.sin(np.arange(n) / 500)
    peaks = rng.choice(n, 5, replace=False)
    values[peaks] += np.array([5.0, -7.0, 3.0, -4.0, 6.0])
    chosen = screen_samples(values, 3000)
    assert len(chosen) <= 3000
    assert np.all(np.diff(chosen) > 0)
    assert {int(values.argmax()), int(values.argmin()), 0, n - 1} <= set(chosen.tolist())
