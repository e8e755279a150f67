"""Runs over a transport, without the command line."""

from __future__ import annotations

from pathlib import Path

import pytest

from flexros.errors import InputError, InterruptedRunError, RunError
from flexros.logs.reader import read_log
from flexros.scenario import transports
from flexros.scenario.scenario import load_scenario
from flexros.scenario.transports import RunResult, run_direct, run_ros

SHORT = load_scenario("circle_pd").with_values({"duration": 0.2}, "test")


def test_a_direct_run_reports_progress_and_leaves_a_log(tmp_path: Path) -> None:
    reported: list[tuple[int, int]] = []
    result = run_direct(SHORT, tmp_path / "log", lambda done, total: reported.append((done, total)))
    assert (result.exit_code, result.transport, result.message) == (0, "direct", "")
    assert reported[-1] == (result.samples, result.samples)
    assert len(read_log(tmp_path / "log").joint_states.stamp) == result.samples
    result.require_complete()


def test_an_existing_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="exists already") as caught:
        run_direct(SHORT, tmp_path)
    assert caught.value.argument == "out"


def test_a_missing_package_of_the_nodes_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(transports, "ros_runner", lambda: (None, "no rclpy"))
    with pytest.raises(InputError, match="'ros' cannot be used: no rclpy") as caught:
        run_ros(SHORT, tmp_path / "log")
    assert caught.value.argument == "transport"


@pytest.mark.parametrize(("code", "error"), [(3, RunError), (130, InterruptedRunError)])
def test_an_incomplete_run_is_an_error_of_its_exit_code(code: int, error: type[RunError]) -> None:
    result = RunResult(code, "stopped at 0.1 s", "direct", None, 200, 0.1, 0.1)
    with pytest.raises(error, match=r"^first: stopped at 0\.1 s$") as caught:
        result.require_complete("first")
    assert caught.value.exit_code == code
