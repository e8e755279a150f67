"""A system clock that is set while a run goes on: nodes look at steady clocks alone."""

from __future__ import annotations

import ast
import time
from collections.abc import Callable
from itertools import count
from pathlib import Path

import pytest

from flexros.logs.reader import read_log
from flexros.logs.time_series import Log
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario

MODULES = sorted((Path(__file__).parents[2] / "nodes").glob("*.py"))
STEADY = {"perf_counter", "perf_counter_ns", "monotonic", "monotonic_ns", "thread_time", "sleep"}
NAMES_A_FOLDER = {"launch_plan.py": {"datetime"}}


def clocks_in(path: Path) -> set[str]:
    """Name what a module takes from `time` and `datetime`, and calls of the ROS clock of a node."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module in ("time", "datetime"):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names if alias.name in ("time", "datetime")}
        elif isinstance(node, ast.Attribute) and node.attr == "get_clock":
            found.add("get_clock")
    return found


@pytest.mark.parametrize("path", MODULES, ids=lambda path: path.name)
def test_nodes_look_at_steady_clocks_alone(path: Path) -> None:
    assert clocks_in(path) - STEADY <= NAMES_A_FOLDER.get(path.name, set())


@pytest.mark.parametrize("path", MODULES, ids=lambda path: path.name)
def test_timers_follow_a_steady_clock(path: Path) -> None:
    calls = [
        {keyword.arg: ast.unparse(keyword.value) for keyword in node.keywords}
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr == "create_timer"
    ]
    assert all("steady_clock" in keywords.get("clock", "") for keywords in calls)


def test_jumps_of_the_time_of_day_change_no_bit(
    ros_domain: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, log_differences: Callable[[Log, Log], list[str]]
) -> None:
    from flexros_nodes.bringup.run import run_scenario

    now, calls = time.time(), count()
    monkeypatch.setattr(time, "time", lambda: now + 3600.0 * (-1) ** next(calls))
    monkeypatch.setattr(time, "time_ns", lambda: round((now + 3600.0 * (-1) ** next(calls)) * 1e9))
    assert run_scenario("circle_dae", tmp_path / "log").exit_code == 0
    assert (
        log_differences(closed_loop(Experiment.prepare(load_scenario("circle_dae"))), read_log(tmp_path / "log")) == []
    )
