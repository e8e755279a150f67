"""Steps of the system clock during a run: nodes use steady clocks only."""

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

NODES = Path(__file__).parents[3] / "nodes"
STEADY = {"perf_counter", "perf_counter_ns", "monotonic", "monotonic_ns", "thread_time", "CLOCK_MONOTONIC", "sleep"}
NAMES_A_FOLDER = {"launch_plan.py": {"datetime"}}


def clocks_in(tree: ast.Module) -> set[str]:
    """Name what a module takes from `time` and `datetime`, and calls of the ROS clock of a node."""
    clocks = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module in ("time", "datetime"):
            clocks |= {alias.name for alias in node.names}
        elif isinstance(node, ast.Import):
            clocks |= {alias.name for alias in node.names if alias.name in ("time", "datetime")}
        elif isinstance(node, ast.Attribute) and node.attr == "get_clock":
            clocks.add("get_clock")
    return clocks


def timer_clocks_in(tree: ast.Module) -> list[str]:
    """Name the clock of each timer that a module creates, empty where it names none."""
    return [
        next((ast.unparse(keyword.value) for keyword in node.keywords if keyword.arg == "clock"), "")
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr == "create_timer"
    ]


def test_nodes_and_their_timers_use_steady_clocks_only() -> None:
    timers = 0
    for path in sorted(NODES.rglob("*.py")):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        assert clocks_in(tree) - STEADY <= NAMES_A_FOLDER.get(path.name, set()), path
        clocks = timer_clocks_in(tree)
        timers += len(clocks)
        assert all("steady_clock" in clock for clock in clocks), path
    assert timers >= 3


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
