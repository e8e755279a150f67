"""A node as a child process."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest

from flexros_nodes.bringup.node_process import NodeProcess

pytestmark = pytest.mark.usefixtures("ros_domain")


@pytest.fixture
def process(tmp_path: Path) -> NodeProcess:
    return NodeProcess("plant", {"scenario": "circle_dae", "autostart": False}, tmp_path)


def test_process_stopped_during_its_start_ends_without_error(process: NodeProcess) -> None:
    process.stop(20.0)
    assert process.ended
    assert process.death() == ""


def test_process_ends_though_its_parent_ignores_ctrl_c(tmp_path: Path) -> None:
    """As one that a shell started in the background does; its children inherit that."""
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        process = NodeProcess("plant", {"scenario": "circle_dae", "autostart": False}, tmp_path)
    finally:
        signal.signal(signal.SIGINT, before)
    process.stop(20.0)
    assert process.death() == ""


def test_killed_process_is_reported(process: NodeProcess) -> None:
    os.kill(process.pid, signal.SIGKILL)
    process.stop(20.0)
    assert process.killed
    assert process.death() == "the process of node plant was killed by SIGKILL"


def test_module_that_does_not_exist_gives_its_last_words(tmp_path: Path) -> None:
    process = NodeProcess("nothing", {}, tmp_path)
    process.wait(20.0)
    assert process.death().startswith("the process of node nothing ended with exit code 1, its last output:")
    assert "No module named flexros_nodes.nothing" in process.death()
