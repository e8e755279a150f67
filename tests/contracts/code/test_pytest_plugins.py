"""The tests start beside the pytest plugins of a sourced ROS 2, which may not know the pytest of the environment."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

CHECKOUT = Path(__file__).parents[3]
PLUGINS = ("launch_testing", "launch_testing_ros_pytest_entrypoint", "launch_pytest")


@pytest.fixture
def sourced(tmp_path: Path) -> Path:
    """Make a folder of packages with plugins of those names that cannot be loaded."""
    (tmp_path / "broken_plugin.py").write_text("raise TypeError('hook of another pytest')\n")
    info = tmp_path / "sourced_ros-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: sourced-ros\nVersion: 1.0\n")
    points = "".join(f"{name} = broken_plugin\n" for name in PLUGINS)
    (info / "entry_points.txt").write_text(f"[pytest11]\n{points}")
    return tmp_path


@pytest.mark.parametrize("configured", [True, False])
def test_plugins_of_ros_are_not_loaded(sourced: Path, configured: bool) -> None:
    options = [] if configured else ["-o", "addopts="]  # without those of pyproject.toml pytest ends with an error
    done = subprocess.run(
        [
            sys.executable,
            "-m",
            "pytest",
            "--collect-only",
            "tests/test_one_line.py",
            "-p",
            "no:cacheprovider",
            *options,
        ],
        cwd=CHECKOUT,
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(sourced), str(CHECKOUT)])},
        capture_output=True,
        text=True,
    )
    assert (done.returncode == 0) == configured, done.stdout + done.stderr
    assert ("hook of another pytest" in done.stderr) != configured
