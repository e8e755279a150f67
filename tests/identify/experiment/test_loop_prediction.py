"""Torque predicted by the linear closed loop against the simulated one."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from flexros.identify.experiment.loop_prediction import LoopPrediction
from flexros.robot import load_robot
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import Scenario

pytestmark = pytest.mark.slow

Scenarios = Callable[..., Scenario]


@pytest.mark.parametrize(
    "slow",
    [{"kind": "none"}, {"kind": "sine", "speed": 0.1}, {"kind": "constant_speed", "speed": 0.09}],
    ids=lambda slow: str(slow["kind"]),
)
def test_prediction_equals_the_simulation(scenario_of: Scenarios, slow: dict[str, object]) -> None:
    scenario = scenario_of(slow_motion=slow, transient_periods=8).with_values({"noise": False})
    experiment = Experiment.prepare(scenario)
    effort = closed_loop(experiment).joint_commands.effort  # type: ignore[union-attr]
    plan, robot = experiment.plan, experiment.nominal
    assert plan is not None
    assert effort is not None
    prediction = LoopPrediction.of(plan, robot, scenario.controller)
    for s in plan.segments:
        lead = plan.visits[s.position].lead
        state = robot.equilibrium(robot.home, motor_position=experiment.reference.motor_position[lead])
        at_rest = prediction.at(state)
        torque = at_rest.offset[0] + at_rest.torque(plan.signals(s.position, s.block))[s.experiment]
        found = effort[s.first + s.period : s.stop]
        error = np.std(found - torque, axis=0) / np.std(torque, axis=0)
        assert np.all(error < (0.2 if slow["kind"] == "constant_speed" else 0.03))  # moving changes the inertia


def test_predicted_speed_is_that_of_the_motors(scenario_of: Scenarios) -> None:
    scenario = scenario_of(transient_periods=4).with_values({"noise": False})
    experiment = Experiment.prepare(scenario)
    position = closed_loop(experiment).joint_states.position
    plan, robot = experiment.plan, experiment.nominal
    assert plan is not None
    assert position is not None
    state = robot.equilibrium(robot.home, motor_position=plan.positions[0])
    speed = LoopPrediction.of(plan, robot, scenario.controller).at(state).speed(plan.signals(0, 0))[0]
    first = plan.segments[0].first
    found = (position[first + 1 : first + 1001] - position[first - 1 : first + 999]) / (2.0 * plan.sample_time)
    assert np.max(np.abs(found - speed)) < 0.03 * np.max(np.abs(speed))
    assert np.max(np.abs(found - plan.signals(0, 0).speed[0])) > 0.3 * np.max(
        np.abs(speed)
    )  # not that of the reference


def test_friction_at_constant_speed_is_in_the_offset() -> None:
    robot = load_robot("six_axis")
    scenario = Scenario.model_validate(
        {
            "name": "mine",
            "robot": "six_axis",
            "controller": {"kind": "pid", "kp": 1e5},
            "identification": {
                "positions": [[0.0] * 6],
                "blocks": 1,
                "periods": 1,
                "transient_periods": 0,
                "excitation": {"kind": "multisine", "period": 0.01, "lowest": 50.0, "highest": 400.0},
                "slow_motion": {"kind": "constant_speed", "speed": [0.2, 0, 0, 0, 0, 0]},
            },
        }
    )
    plan = Experiment.prepare(scenario).plan
    assert plan is not None
    low, high = LoopPrediction.of(plan, robot, scenario.controller).at(robot.equilibrium(np.zeros(18))).offset
    assert high[0] - low[0] == pytest.approx(2 * 0.2 * 300.0, rel=1e-3)  # viscous friction of motor_1 both ways
    assert high[1] == pytest.approx(low[1], rel=1e-3)
