"""The guide's MuJoCo plant behind the topics, moved by our controller and feedforward."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flexros.logs.reader import read_log
from flexros.logs.time_series import Log
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario

pytest.importorskip("rclpy", reason="needs ROS 2")
pytest.importorskip("mujoco", reason="the other plant")

from flexros_nodes.controller.node import ControllerNode
from flexros_nodes.feedforward import FeedforwardNode
from flexros_nodes.recorder import RecorderNode

EXAMPLES = Path(__file__).parents[3] / "docs" / "examples"
SCENARIO = EXAMPLES / "two_mass_move.yaml"
MODEL = EXAMPLES / "two_mass.xml"

StartProcess = Callable[..., subprocess.Popen[str]]


@pytest.fixture
def run_on_mujoco(bench: Any, start_example: StartProcess, end_with_plant: Callable[..., str]) -> Callable[[Path], Log]:
    """Give a run of the scenario's controller and feedforward on a MuJoCo model to its end."""

    def run(model: Path) -> Log:
        folder, scenario = model.parent / "log", str(SCENARIO)
        ours = [bench.add(kind, scenario=scenario) for kind in (ControllerNode, FeedforwardNode)]
        ours.append(bench.add(RecorderNode, scenario=scenario, folder=str(folder)))
        for node in ours:
            node.trigger_configure()
            node.trigger_activate()
        parameters = (f"model:={model}", "duration:=1.0", "listeners:=2", "watchers:=1")
        arguments = ["--ros-args", *(word for one in parameters for word in ("-p", one))]
        plant = start_example("mujoco_plant.py", *arguments)
        assert end_with_plant(plant, spin=lambda: bench.spin_for(0.02)).startswith("1001 samples")
        for node in ours:
            node.trigger_shutdown()
        return read_log(folder)

    return run


@pytest.mark.parametrize(
    ("integrator", "position_error", "torque_error"),
    [("RK4", 1e-12, 1e-8), ("implicitfast", 1.5e-4, 1.0)],
)
def test_run_on_mujoco_is_the_run_on_our_plant_but_for_the_integrator(
    run_on_mujoco: Callable[[Path], Log], tmp_path: Path, integrator: str, position_error: float, torque_error: float
) -> None:
    model = tmp_path / "model.xml"
    model.write_text(MODEL.read_text(encoding="utf-8").replace("RK4", integrator), encoding="utf-8")
    foreign = run_on_mujoco(model)
    scenario = load_scenario(str(SCENARIO)).with_values({"noise": False, "duration": 1.0})
    ours = closed_loop(Experiment.prepare(scenario))
    assert foreign.warnings == ()
    for one, other in ((foreign.joint_states.position, ours.joint_states.position), positions_of_tool(foreign, ours)):
        np.testing.assert_allclose(one, other, rtol=0, atol=position_error)
        assert np.ptp(other) > 0.02
    assert foreign.joint_commands is not None
    assert ours.joint_commands is not None
    np.testing.assert_allclose(foreign.joint_commands.effort, ours.joint_commands.effort, rtol=0, atol=torque_error)
    np.testing.assert_array_equal(foreign.joint_states.stamp, ours.joint_states.stamp)


def positions_of_tool(*logs: Log) -> tuple[np.ndarray, ...]:
    poses = [log.tool_pose for log in logs]
    return tuple(pose.position for pose in poses if pose is not None)
