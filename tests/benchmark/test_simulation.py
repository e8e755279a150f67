"""Runs in SIMD lanes against the closed loop of a scenario."""

from __future__ import annotations

import numpy as np

from flexros.benchmark.disturbances import DISTURBANCES
from flexros.benchmark.evaluate import NOISE
from flexros.benchmark.models import NOMINAL, ROBOT, set_values
from flexros.benchmark.simulation import RegulatorSimulation
from flexros.robot import load_robot
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario


def test_scenario_has_the_disturbances_and_noise_of_the_benchmark() -> None:
    scenario = load_scenario("feedback_benchmark")
    assert scenario.disturbances == DISTURBANCES
    assert scenario.model.values == {"encoder_noise": NOISE, "tool_noise": 0.0}


def test_nominal_run_equals_the_scenario_to_the_last_bit() -> None:
    scenario = load_scenario("feedback_benchmark")
    robot = load_robot(ROBOT)
    runs = RegulatorSimulation(robot).run(
        scenario.controller,
        set_values(robot, NOMINAL),
        lambda _, z, u: (z.copy(), u.copy()),
        noise=NOISE,
        seeds=(scenario.seed,),
    )
    deflection, command = runs[0][0]
    log = closed_loop(Experiment.prepare(scenario))
    assert np.array_equal(command, log.joint_commands.effort[:, 0])
    assert np.array_equal(deflection, 1e3 * log.tool_pose.position[:, 0])
