"""Runs in SIMD lanes against the closed loop of a scenario."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from flexros.arrays import FloatArray
from flexros.benchmark.controllers import load_controller
from flexros.benchmark.disturbances import DISTURBANCES
from flexros.benchmark.evaluate import NOISE
from flexros.benchmark.models import NOMINAL, ROBOT, benchmark_robot, set_values
from flexros.benchmark.simulation import RegulatorSimulation
from flexros.control.base import AbstractControlLaw
from flexros.robot import Robot, load_robot
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario


def nominal_run(robot: Robot, law: AbstractControlLaw, seed: int) -> tuple[FloatArray, FloatArray]:
    """Run the nominal model of the benchmark; return tool deflection [mm] and torque command [Nm]."""
    runs = RegulatorSimulation(robot).run(
        law, set_values(robot, NOMINAL), lambda _, z, u: (z.copy(), u.copy()), noise=NOISE, seeds=(seed,)
    )
    return runs[0][0]


def test_scenario_has_the_disturbances_and_noise_of_the_benchmark() -> None:
    scenario = load_scenario("feedback_benchmark")
    assert scenario.disturbances == DISTURBANCES
    assert scenario.model.values == {"encoder_noise": NOISE, "tool_noise": 0.0}


def test_nominal_run_equals_the_scenario_to_the_last_bit() -> None:
    scenario = load_scenario("feedback_benchmark")
    robot = load_robot(ROBOT)
    deflection, command = nominal_run(robot, scenario.controller, scenario.seed)
    log = closed_loop(Experiment.prepare(scenario))
    assert np.array_equal(command, log.joint_commands.effort[:, 0])
    assert np.array_equal(deflection, 1e3 * log.tool_pose.position[:, 0])


def test_design_with_tool_acceleration_equals_its_scenario_to_the_last_bit(tmp_path: Path) -> None:
    controller = load_controller("acceleration_1")
    robot = benchmark_robot(controller.sensors)
    data = robot.spec.model_dump(mode="json")
    (tmp_path / "robot.yaml").write_text(json.dumps(data))  # JSON is YAML
    law = {"kind": "state_space", **controller.nominal.model_dump(mode="json")}
    scenario = load_scenario("feedback_benchmark").with_values(
        {"robot": str(tmp_path / "robot.yaml"), "controller": law, "duration": 4.0}
    )
    deflection, command = nominal_run(robot, controller.nominal, scenario.seed)
    log = closed_loop(Experiment.prepare(scenario))
    assert log.joint_commands is not None
    assert log.tool_pose is not None
    assert log.joint_commands.effort is not None
    n = len(log.joint_commands.effort)
    assert n == 8001
    assert np.array_equal(command[:n], log.joint_commands.effort[:, 0])
    assert np.array_equal(deflection[:n], 1e3 * log.tool_pose.position[:, 0])
