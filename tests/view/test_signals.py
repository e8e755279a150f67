from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from flexros.effects.patching.patched_robot import load_model
from flexros.logs.reader import read_log
from flexros.robot import load_robot
from flexros.view.motion import robot_motion
from flexros.view.shown import shown_log
from flexros.view.signals import peaks, signal_plots

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


def test_log_of_a_driver_shows_positions_and_measured_torques(circle: Path) -> None:
    log = read_log(circle)
    effort = np.outer(np.arange(len(log.joint_states.stamp)), [1.0, -2.0])
    states = replace(log.joint_states, effort=effort)
    log = replace(log, joint_states=states, joint_commands=None, joint_reference=None)
    motion = robot_motion(log, load_model("e12"), "log")
    plots = {plot.title: plot for plot in signal_plots(log, load_robot("e12"), motion, None)}
    assert list(plots)[-2:] == ["measured torque [Nm]", "motor positions [rad]"]
    assert plots["measured torque [Nm]"].values[1].min() == pytest.approx(effort[:, 1].min(), abs=4)
    np.testing.assert_allclose(plots["motor positions [rad]"].values[:, 0], states.position[0], atol=1e-2)
