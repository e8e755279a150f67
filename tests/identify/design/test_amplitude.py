"""Room for the excitation: against the torque of a simulated experiment."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.identify.design.amplitude import CREST, amplitude_room
from flexros.identify.design.position_information import experiment_conditions
from flexros.robot import load_robot
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario

pytestmark = pytest.mark.slow


def test_room_is_what_the_simulated_torque_leaves() -> None:
    """Limits of a controller at 3000 Nm: room times rms of the simulated torque times the crest is 95 % of them."""
    scenario = load_scenario("identify_e12").with_values(
        {"noise": False, "controller.torque_limit": 3000.0, "identification.positions": [[0, 0.3]],
         "identification.blocks": 1, "identification.transient_periods": 1}
    )  # fmt: skip
    robot, specification = load_robot("e12"), scenario.identification
    assert specification is not None
    conditions = experiment_conditions(specification, robot, 5e-4, scenario.seed)
    motors = np.array([[0.0, 0.3]])
    room = amplitude_room(robot, motors, conditions, scenario.controller, 5e-4, 0.95)
    experiment = Experiment.prepare(scenario)
    log = closed_loop(experiment)
    assert experiment.plan is not None
    parts = [slice(one.first, one.first + one.n_periods * one.period) for one in experiment.plan.segments]
    rms = max(np.sqrt(np.mean(log.joint_commands.effort[part] ** 2, axis=0)).max() for part in parts)
    assert room == pytest.approx(0.95 * 3000 / (CREST * rms), rel=0.05)


def test_room_without_limits_is_infinite_and_none_where_gravity_takes_all() -> None:
    scenario = load_scenario("identify_six_axis")
    assert scenario.identification is not None
    robot = load_robot("six_axis")
    conditions = experiment_conditions(scenario.identification, robot, 5e-4, 1, most_lines=10)
    motors = np.array([[0, 0.9, 0.9, 0, 0, 0.0]])
    assert amplitude_room(robot, motors, conditions, scenario.controller, 5e-4, 0.95) > 0
    weak = scenario.with_values({"controller.torque_limit": 500.0}).controller
    assert amplitude_room(robot, motors, conditions, weak, 5e-4, 0.95) == 0
    free = load_robot("e12")
    e12 = load_scenario("identify_e12")
    assert e12.identification is not None
    flat = experiment_conditions(e12.identification, free, 5e-4, 1, most_lines=10)
    assert amplitude_room(free, np.array([[0.0, 0.3]]), flat, e12.controller, 5e-4, 0.95) == np.inf
