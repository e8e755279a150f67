from __future__ import annotations

import numpy as np
import pytest

from flexros.analysis.error_statistics import error_statistics


def test_figures_of_a_known_series():
    error = np.array([0.0, -3.0, 1.0, 2.0])
    figures = error_statistics(error, np.arange(4) * 0.1, np.arange(4) * 0.5)
    assert figures.maximum == 3.0
    assert figures.rms == pytest.approx(np.sqrt(14 / 4))
    assert figures.time_of_maximum == pytest.approx(0.1)
    assert figures.position_of_maximum == pytest.approx(0.5)
    assert figures.count == 4


def test_percentile_leaves_five_percent_above():
    error = np.arange(1001) / 1000
    assert error_statistics(error, error).percentile_95 == pytest.approx(0.95)
