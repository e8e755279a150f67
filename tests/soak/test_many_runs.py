"""Processes left behind by runs are detected."""

from __future__ import annotations

import os
import subprocess
import time
from pathlib import Path

import psutil
import pytest

pytest.importorskip("rclpy", reason="needs ROS 2")

from tests.soak.many_runs import others_of


def test_process_whose_parent_has_ended_is_seen(tmp_path: Path) -> None:
    variables = {**os.environ, "TMPDIR": str(tmp_path)}
    left = int(subprocess.check_output(["sh", "-c", "sleep 60 >/dev/null & echo $!"], env=variables, text=True))
    try:
        until = time.monotonic() + 10.0
        while (found := others_of(tmp_path)) != ["sleep 60"] and time.monotonic() < until:
            time.sleep(0.05)
        assert found == ["sleep 60"]
    finally:
        psutil.Process(left).kill()
    assert others_of(tmp_path / "another") == []
