from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.view.shown import shown_log
from flexros.view.signals import peaks

if TYPE_CHECKING:
    from pathlib import Path


def test_peaks_survive_the_reduction() -> None:
    time = np.linspace(0.0, 1.0, 10_001)
    values = np.zeros((10_001, 2))
    values[4321, 0], values[1234, 1] = 5.0, -3.0
    reduced = peaks(time, values, np.linspace(0.0, 1.0, 101))
    assert reduced[:, 0].max() == 5.0
    assert reduced[:, 1].min() == -3.0
    assert np.argmax(reduced[:, 0]) == 43


def test_slow_series_is_joined_between_its_values() -> None:
    reduced = peaks(np.array([0.0, 1.0]), np.array([[0.0], [1.0]]), np.linspace(0.0, 1.0, 11))
    np.testing.assert_allclose(reduced[:, 0], np.linspace(0.0, 1.0, 11))


def test_plots_share_the_time_of_the_log(circle: Path) -> None:
    plots = shown_log(circle).plots
    titles = [plot.title for plot in plots]
    assert titles[0] == "path error [mm]"
    assert {"deflection [mrad]", "tracking error [mrad]", "torque command [Nm]"} <= set(titles)
    assert all(np.array_equal(plot.time, plots[0].time) for plot in plots)
    assert 2.0 < plots[0].values.max() < 2.2, "the path error of this run is 2.1 mm"
