"""Logs of simulated robots with further sensors: they show no gap, unless delay and mounting are left out."""

from __future__ import annotations

from functools import cache

import pytest

from flexros.effects import RobotWithEffects
from flexros.gap.measure_gap import MeasuredGap, measure_gap
from flexros.record.read import read_record
from flexros.robot import load_robot
from flexros.robot.robot import Robot, robot_from_data
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario
from tests.scenario.test_sensor_series import robot_file

pytestmark = pytest.mark.slow

LATE = {
    "link": {"position": {"noise": 2e-6}, "torque": {"noise": 0.5, "bias": 2.0}, "delay": 1e-3, "rate": 500},
    "tool_imu": {
        "acceleration": {"noise": 0.02, "axes": ["x", "z"], "bias": [0.3, 0.0, -0.2]},
        "position": [0.1, 0.0, 0.05],
        "orientation": [0.0, 0.4, 0.0],
        "delay": 2e-3,
        "rate": 1000,
    },
}


def robot(sensors: object) -> Robot:
    data = load_robot("elbow").spec.model_dump()
    return robot_from_data({**data, "sensors": {**data["sensors"], **sensors}}, "test")  # type: ignore[dict-item]


@cache
def gap(folder: str, **changes: float) -> MeasuredGap:
    scenario = load_scenario("elbow_kalman").with_values({"robot": folder, **changes})
    record = read_record(closed_loop(Experiment.prepare(scenario)), robot(LATE), name="log")
    assert {sensor.quantity for sensor in record.sensors} == {"link position", "joint torque", "tool acceleration"}
    return measure_gap(record, RobotWithEffects(robot(LATE), ()))


@pytest.fixture(scope="module")
def late(tmp_path_factory: pytest.TempPathFactory) -> str:
    return robot_file(tmp_path_factory.mktemp("robot"), "elbow", LATE)


def test_late_slow_biased_and_turned_sensors_are_no_gap(late: str) -> None:
    found = gap(late)
    assert found.numbers.before == pytest.approx(1.0, abs=0.1)
    assert not found.significant


def test_a_stiffness_beyond_tolerance_is_one(late: str) -> None:
    found = gap(late, **{"plant.values.body_1.ry.stiffness": 2.1e5})
    assert found.numbers.before > 50
    assert found.significant


def test_a_robot_file_without_delay_and_mounting_is_one(late: str) -> None:
    bare = {
        "link": {"position": {"noise": 2e-6}, "torque": {"noise": 0.5}},
        "tool_imu": {"acceleration": {"noise": 0.02, "axes": ["x", "z"]}},
    }
    log = closed_loop(Experiment.prepare(load_scenario("elbow_kalman").with_values({"robot": late})))
    found = measure_gap(read_record(log, robot(bare), name="log"), RobotWithEffects(robot(bare), ()))
    assert found.numbers.before > 50
