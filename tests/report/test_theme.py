from __future__ import annotations

import warnings

import numpy as np

from flexros.report.theme import compact


def test_seven_digits_are_kept():
    values = np.array([0.0, -1.2345678, 3e-9, 4e20])
    np.testing.assert_allclose(compact(values), values, rtol=1e-7)


def test_numbers_of_a_diverged_run_stay_finite_without_a_warning():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        drawn = compact(np.array([1e300, -1e300, np.nan]))
    assert np.all(np.isfinite(drawn[:2]))
    assert drawn[0] == -drawn[1] > 1e38
    assert np.isnan(drawn[2])
