"""Logs for the tests of the monitor: a course of 12 to 17 s that shows friction, gears and inertia."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import pytest

from flexros.effects import RobotWithEffects
from flexros.effects.patching.patched_robot import load_model
from flexros.logs.time_series import Log
from flexros.monitor.gap_monitor import GapMonitor
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario


@cache
def course(robot: str, effect: str = "", seed: int = 11) -> Log:
    changes = {"robot": robot, "diagnosis.length": 12, "seed": seed}
    if effect:
        changes["plant.effects"] = [effect]
    return closed_loop(Experiment.prepare(load_scenario("diagnosis").with_values(changes, "test")))


@pytest.fixture
def make_log() -> Callable[..., Log]:
    """Give the maker of a log: robot, effect, seed."""
    return course


@pytest.fixture
def elbow() -> RobotWithEffects:
    return load_model("elbow")


@pytest.fixture
def make_monitor() -> Callable[[str], GapMonitor]:
    """Give the maker of a monitor of a robot."""
    return lambda robot: GapMonitor(load_model(robot))
