"""The guide's controller without FlexROS, run as a process against the plant."""

from __future__ import annotations

import ast
import json
import signal
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from flexros.logs.reader import read_log
from flexros.logs.time_series import Log
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario

if TYPE_CHECKING:
    from flexros.arrays import FloatArray

pytest.importorskip("rclpy", reason="needs ROS 2")

from rclpy.parameter import Parameter

from flexros_nodes.recorder import RecorderNode
from tests.nodes.loop_on_bench import Loop

EXAMPLE = "foreign_controller.py"
TIMEOUT = 60.0
GAINS = {"kind": "pid", "kp": 5600.0, "ki": 24000.0, "kd": 300.0}

StartProcess = Callable[..., subprocess.Popen[str]]
Recorded = Callable[..., Log]


def scenario_file(folder: Path, **changes: Any) -> Path:
    settings = {**load_scenario("two_mass_step").settings(), "controller": GAINS, "noise": False, **changes}
    path = folder / "scenario.yaml"
    path.write_text(json.dumps({**settings, "duration": 1.0}), encoding="utf-8")
    return path


@pytest.fixture
def recorded(bench: Any, start_example: StartProcess) -> Recorded:
    """Give a run of plant, recorder and the foreign controller, a process of its own, to the plant's end."""

    def run(scenario: Path, *parameters: str) -> Log:
        arguments = [word for parameter in parameters for word in ("-p", parameter)]
        foreign = start_example(EXAMPLE, *(["--ros-args", *arguments] if arguments else []))
        folder = scenario.parent / "log"
        loop = Loop(bench, scenario, RecorderNode)
        loop.node(RecorderNode).set_parameters([Parameter("folder", value=str(folder))])
        loop.bring_up()
        bench.spin_until(lambda: loop.plant.report is not None, TIMEOUT)
        loop.finish()
        foreign.send_signal(signal.SIGTERM)
        _, errors = foreign.communicate(timeout=TIMEOUT)
        assert foreign.returncode == 0, errors
        return read_log(folder)

    return run


def signals(log: Log) -> tuple[FloatArray, FloatArray]:
    """Motor positions and torques of a log."""
    assert log.joint_commands is not None
    assert log.joint_commands.effort is not None
    assert log.joint_states.position is not None
    return log.joint_states.position, log.joint_commands.effort


def test_example_is_short_and_imports_nothing_of_flexros() -> None:
    text = (Path(__file__).parents[3] / "docs" / "examples" / EXAMPLE).read_text(encoding="utf-8")
    imports = {node.module for node in ast.walk(ast.parse(text)) if isinstance(node, ast.ImportFrom)}
    assert imports == {"rclpy.node", "rclpy.signals", "sensor_msgs.msg"}
    assert len([line for line in text.splitlines() if line.strip()]) <= 40


def test_holds_against_disturbances_sample_for_sample_as_the_same_law_of_ours(
    recorded: Recorded, tmp_path: Path
) -> None:
    disturbances = [
        {"kind": "step", "at": "motor_1", "start": 0.2, "amplitude": 100.0},
        {"kind": "step", "at": "tool.tz", "start": 0.6, "amplitude": 100.0},
    ]
    scenario = scenario_file(tmp_path, disturbances=disturbances)
    log = recorded(scenario)
    ours = closed_loop(Experiment.prepare(load_scenario(str(scenario))))
    np.testing.assert_allclose(signals(log)[0], signals(ours)[0], rtol=0, atol=1e-12)
    np.testing.assert_allclose(signals(log)[1], signals(ours)[1], rtol=0, atol=1e-6)
    assert np.ptp(signals(ours)[0]) > 1e-3


def test_motor_follows_its_swing(recorded: Recorded, tmp_path: Path) -> None:
    scenario = scenario_file(tmp_path, disturbances=[])
    log = recorded(scenario, "swing:=0.2", "period:=1.0")
    position, _ = signals(log)
    swing = 0.2 * np.sin(np.pi * np.arange(1001) * 1e-3) ** 2
    assert np.max(np.abs(position[:, 0] - swing)) < 0.02
    assert np.max(position) > 0.19
