"""The observer model of robots that equal their model."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from flexros.effects.patching.patched_robot import load_model
from flexros.errors import InputError
from flexros.logs.time_series import Log
from flexros.monitor.observer_model import ObserverModel
from flexros.monitor.sample_stream import SampleStream
from flexros.monitor.watch import Watch, WindowResult


def results_of(log: Log, robot: str, first: int = 0, *, torque: float = 0.0) -> tuple[list[WindowResult], Watch, int]:
    """Watch a log from a sample on, with a constant added to the commands [Nm]."""
    model = load_model(robot)
    stream = SampleStream(model.robot.sample_time, model.robot.n_motors)
    states, commands = log.joint_states, log.joint_commands
    assert states.position is not None
    assert commands is not None
    assert commands.effort is not None
    stream.add_states(states.stamp[first:], states.position[first:])
    stream.add_commands(commands.stamp[first:], commands.effort[first:] + torque)
    windows = list(stream.windows())
    watch = Watch(model, stream.sample_time, stream.samples)
    return [one for window in windows if (one := watch.take(window)) is not None], watch, len(windows)


@pytest.mark.slow
@pytest.mark.parametrize("robot", ["four_mass_linear", "elbow", "e12", "two_mass", "emps"])
def test_noise_alone_is_seen_of_a_robot_that_is_as_its_model(robot: str, make_log: Callable[..., Log]) -> None:
    found, watch, windows = results_of(make_log(robot), robot)
    assert len(found) > 0.4 * windows
    assert watch.runaways == 0
    assert np.mean([one.innovation for one in found], axis=0) == pytest.approx(1.0, abs=0.05)
    assert np.mean([one.disturbance for one in found], axis=0) == pytest.approx(1.0, abs=0.5)


def test_a_start_in_motion_is_found(make_log: Callable[..., Log]) -> None:
    log = make_log("elbow")
    assert log.joint_states.position is not None
    speed = np.abs(np.diff(log.joint_states.position, axis=0)).max(axis=1)
    fast = int(np.argmax(speed > 0.9 * speed[: len(speed) // 2].max()))
    found, watch, _ = results_of(log, "elbow", fast)
    assert watch._observer.starts_in_motion
    assert found[0].disturbance.max() < 10.0
    assert np.mean([one.disturbance for one in found], axis=0) == pytest.approx(1.0, abs=0.5)


def test_the_missing_torque_is_told_in_its_size(make_log: Callable[..., Log]) -> None:
    """Commands that say 3 Nm too much: the robot misses 3 Nm."""
    found, _, _ = results_of(make_log("elbow"), "elbow", torque=3.0)
    np.testing.assert_allclose(np.median([one.torque[0] for one in found], axis=0), -3.0, rtol=0.02)


def test_a_robot_that_is_another_one_is_lost_and_found_again(make_log: Callable[..., Log]) -> None:
    log = make_log("elbow")
    found, watch, windows = results_of(log, "elbow", torque=1e9)
    assert watch.runaways > 0
    assert len(found) < windows


def test_a_robot_without_a_rest_from_the_first_window_on_is_lost_and_can_be_asked_about(
    make_log: Callable[..., Log], monkeypatch: pytest.MonkeyPatch
) -> None:
    def no_rest(*_: object) -> None:
        raise InputError("no rest here")

    monkeypatch.setattr(ObserverModel, "begin", no_rest)
    found, watch, windows = results_of(make_log("elbow"), "elbow")
    assert (found, watch.runaways) == ([], windows)
    assert np.all(watch.here.design.torque_spread > 0)
