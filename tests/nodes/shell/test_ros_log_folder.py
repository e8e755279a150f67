"""ROS 2 without a home folder: service accounts and containers."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from flexros.errors import RunError

pytest.importorskip("rclpy", reason="needs ROS 2")

from flexros_nodes.shell.ros_log_folder import ros_log_settings

CHECKOUT = Path(__file__).parents[3]
NOWHERE = "/proc/1/nowhere"
"""A folder that nobody can make, not even root."""

RUN = """
from flexros_nodes.bringup.run import run_scenario
from flexros.scenario.scenario import load_scenario
summary = run_scenario(load_scenario("circle_pd").with_values({"duration": 0.01}), None)
raise SystemExit(summary.exit_code)
"""


@pytest.mark.parametrize(
    "given", [{}, {"HOME": NOWHERE}, {"ROS_HOME": NOWHERE, "HOME": "/tmp"}, {"ROS_LOG_DIR": NOWHERE}]
)
def test_folder_that_cannot_be_written_is_replaced(given: dict[str, str]) -> None:
    settings = ros_log_settings(given)
    assert list(settings) == ["ROS_LOG_DIR"]
    assert Path(settings["ROS_LOG_DIR"]).is_dir()


@pytest.mark.parametrize("variable", ["ROS_LOG_DIR", "ROS_HOME", "HOME"])
def test_folder_of_the_user_stays(tmp_path: Path, variable: str) -> None:
    assert ros_log_settings({variable: str(tmp_path)}) == {}


def test_no_folder_at_all_is_one_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tempfile, "gettempdir", lambda: NOWHERE)
    with pytest.raises(RunError, match="set ROS_LOG_DIR to a folder that can be written"):
        ros_log_settings({})


@pytest.mark.usefixtures("ros_domain")
@pytest.mark.parametrize("home", [None, NOWHERE])
def test_run_needs_no_home(home: str | None) -> None:
    environment = {name: value for name, value in os.environ.items() if name not in ("HOME", "ROS_HOME", "ROS_LOG_DIR")}
    environment |= {"PYTHONPATH": str(CHECKOUT)} | ({"HOME": home} if home else {})
    done = subprocess.run([sys.executable, "-c", RUN], env=environment, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
