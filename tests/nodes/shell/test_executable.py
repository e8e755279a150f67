"""Nodes as executables, the way `ros2 run` starts them."""

from __future__ import annotations

import json
import os
import signal
import subprocess
from collections.abc import Callable
from pathlib import Path
from time import monotonic, sleep

import pytest

from flexros.logs.reader import read_log
from flexros.scenario.scenario import load_scenario

StartNode = Callable[..., subprocess.Popen[str]]
CHECKOUT = Path(__file__).parents[3]
TIMEOUT = 60.0
BROUGHT_UP = 4.0
"""Processor time after which a node has loaded its modules and prepares the reference [s]."""

pytestmark = pytest.mark.usefixtures("ros_domain")


@pytest.mark.parametrize(
    ("parameter", "sentence"),
    [
        ("resend_timeout:=.nan", "error: parameter resend_timeout of node plant is nan, allowed is a finite number"),
        ("scenario:=nowhere", "error: unknown scenario 'nowhere'"),
    ],
)
def test_bad_parameter_is_one_sentence_and_exit_code_2(start_node: StartNode, parameter: str, sentence: str) -> None:
    process = start_node("plant", parameter)
    _, errors = process.communicate(timeout=TIMEOUT)
    assert process.returncode == 2
    assert errors.splitlines()[-1].startswith(sentence)
    assert "Traceback" not in errors


def test_node_ends_with_its_parent_also_while_ros_time_is_stopped(start_node: StartNode) -> None:
    process = start_node("feedforward", "parent_process:=1", "use_sim_time:=true", "autostart:=false")
    _, errors = process.communicate(timeout=TIMEOUT)
    assert process.returncode == 0, errors


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_node_that_prepares_its_reference_ends_within_the_grace_of_a_launch(
    start_node: StartNode, tmp_path: Path, number: signal.Signals
) -> None:
    """A reference of 900 s takes over 20 s; `ros2 launch` sends SIGINT, after 5 s SIGTERM and then SIGKILL."""
    scenario = tmp_path / "long.yaml"
    scenario.write_text(json.dumps({**load_scenario("circle_dae").settings(), "duration": 900.0}))
    process = start_node("feedforward", f"scenario:={scenario}")
    at_work = Path(f"/proc/{process.pid}/stat")
    deadline = monotonic() + TIMEOUT
    while sum(map(int, at_work.read_text().rpartition(")")[2].split()[11:13])) < BROUGHT_UP * os.sysconf("SC_CLK_TCK"):
        assert monotonic() < deadline, "the node is not at work"
        assert process.poll() is None, process.communicate()[1]
        sleep(0.05)
    began = monotonic()
    process.send_signal(number)
    _, errors = process.communicate(timeout=TIMEOUT)
    assert process.returncode == 0, errors
    assert monotonic() - began < 5.0


def test_four_executables_find_each_other_and_the_plant_ends_the_run(start_node: StartNode, tmp_path: Path) -> None:
    scenario = "scenario:=circle_dae"
    plant = start_node("plant", scenario)
    others = [start_node("controller", scenario), start_node("feedforward", scenario)]
    recorder = start_node("recorder", scenario, f"folder:={tmp_path / 'log'}")
    try:
        _, errors = plant.communicate(timeout=TIMEOUT)
        assert plant.returncode == 0, errors
        for process in (*others, recorder):
            process.send_signal(signal.SIGINT)
            _, errors = process.communicate(timeout=TIMEOUT)
            assert process.returncode == 0, errors
    finally:
        for process in (plant, *others, recorder):
            process.kill()
    log = read_log(tmp_path / "log")
    assert log.warnings == ()
    assert len(log.joint_states.stamp) == 762
