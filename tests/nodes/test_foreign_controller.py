"""The guide's controller without FlexROS, run as a process against the plant."""

from __future__ import annotations

import ast
import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from flexros.config.scenario import load_scenario
from flexros.logs.reader import read_log
from flexros.logs.time_series import Log
from flexros.simulate.closed_loop import closed_loop
from flexros.simulate.experiment import Experiment

if TYPE_CHECKING:
    from flexros.arrays import FloatArray

pytest.importorskip("rclpy", reason="needs ROS 2")

EXAMPLE = Path(__file__).parents[2] / "docs" / "guide" / "examples" / "foreign_controller.py"
GAINS = {"kind": "pid", "kp": 5600.0, "ki": 24000.0, "kd": 300.0}
TIMEOUT = 60.0

StartNode = Callable[..., subprocess.Popen[str]]


def scenario_file(folder: Path, **changes: Any) -> Path:
    settings = {**load_scenario("two_mass_step").settings(), "controller": GAINS, "noise": False, **changes}
    path = folder / "scenario.yaml"
    path.write_text(json.dumps({**settings, "duration": 1.0}), encoding="utf-8")
    return path


def recorded(start_node: StartNode, scenario: Path, folder: Path, *parameters: str) -> Log:
    """Run plant, recorder and the foreign controller to the plant's end."""
    arguments = [word for parameter in parameters for word in ("-p", parameter)]
    foreign = subprocess.Popen(
        [sys.executable, str(EXAMPLE), *(["--ros-args", *arguments] if arguments else [])],
        cwd=folder,
        env={key: value for key, value in os.environ.items() if key != "PYTHONPATH"},
        stderr=subprocess.PIPE,
        text=True,
    )
    plant = start_node("plant", f"scenario:={scenario}")
    recorder = start_node("recorder", f"scenario:={scenario}", f"folder:={folder / 'log'}")
    try:
        _, errors = plant.communicate(timeout=TIMEOUT)
        assert plant.returncode == 0, errors
        for process in (recorder, foreign):
            process.send_signal(signal.SIGINT)
            _, errors = process.communicate(timeout=TIMEOUT)
            assert process.returncode == 0, errors
    finally:
        for process in (plant, recorder, foreign):
            process.kill()
    return read_log(folder / "log")


def signals(log: Log) -> tuple[FloatArray, FloatArray]:
    """Motor positions and torques of a log."""
    assert log.joint_commands is not None
    assert log.joint_commands.effort is not None
    assert log.joint_states.position is not None
    return log.joint_states.position, log.joint_commands.effort


def test_example_is_short_and_imports_nothing_of_flexros() -> None:
    text = EXAMPLE.read_text(encoding="utf-8")
    imports = {node.module for node in ast.walk(ast.parse(text)) if isinstance(node, ast.ImportFrom)}
    assert imports == {"rclpy.executors", "rclpy.node", "sensor_msgs.msg"}
    assert len([line for line in text.splitlines() if line.strip()]) <= 40


@pytest.mark.usefixtures("ros_domain")
def test_holds_against_disturbances_sample_for_sample_as_the_same_law_of_ours(
    start_node: StartNode, tmp_path: Path
) -> None:
    disturbances = [
        {"kind": "step", "at": "motor_1", "start": 0.2, "amplitude": 100.0},
        {"kind": "step", "at": "tool.tz", "start": 0.6, "amplitude": 100.0},
    ]
    scenario = scenario_file(tmp_path, disturbances=disturbances)
    log = recorded(start_node, scenario, tmp_path)
    ours = closed_loop(Experiment.prepare(load_scenario(str(scenario))))
    np.testing.assert_allclose(signals(log)[0], signals(ours)[0], rtol=0, atol=1e-12)
    np.testing.assert_allclose(signals(log)[1], signals(ours)[1], rtol=0, atol=1e-6)
    assert np.ptp(signals(ours)[0]) > 1e-3


@pytest.mark.usefixtures("ros_domain")
def test_motor_follows_its_swing(start_node: StartNode, tmp_path: Path) -> None:
    scenario = scenario_file(tmp_path, disturbances=[])
    log = recorded(start_node, scenario, tmp_path, "swing:=0.2", "period:=1.0")
    position, _ = signals(log)
    swing = 0.2 * np.sin(np.pi * np.arange(1001) * 1e-3) ** 2
    assert np.max(np.abs(position[:, 0] - swing)) < 0.02
    assert np.max(position) > 0.19
