"""Model-based laws and further sensors over topics: equal to the direct simulation, sample for sample."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import yaml

from flexros.config.yaml_file import read_yaml
from flexros.logs.reader import read_log
from flexros.logs.time_series import ImuSeries, JointSeries, Log
from flexros.robot.robot import LIBRARY
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import Scenario, load_scenario

pytest.importorskip("rclpy", reason="needs ROS 2")

from flexros_nodes.bringup.run import run_scenario

pytestmark = pytest.mark.usefixtures("ros_domain")

Differences = Callable[[Log, Log], list[str]]
LAWS = (
    "elbow_gravity_pd",
    "elbow_computed_torque",
    "elbow_feedback_linearisation",
    "elbow_quasi_static",
    "elbow_state_feedback",
    "elbow_kalman",
    "elbow_extended_kalman",
    "elbow_accelerometer",
    "elbow_torque_feedback",
    "four_mass_lqg",
    "four_mass_state_space",
    "two_mass_step",
)


def same_sensors(direct: Log, recorded: Log) -> None:
    assert set(direct.other_series) == set(recorded.other_series)
    for name, series in direct.other_series.items():
        other = recorded.series(name)
        assert isinstance(other, JointSeries | ImuSeries)
        assert np.array_equal(series.stamp, other.stamp)
        fields = ("position", "effort") if isinstance(series, JointSeries) else ("acceleration", "turning_rate")
        for field in fields:
            wanted, found = getattr(series, field), getattr(other, field)
            assert (wanted is None) == (found is None)
            assert wanted is None or np.array_equal(wanted, found, equal_nan=True)


def compare(scenario: Scenario, folder: Path, log_differences: Differences) -> Log:
    summary = run_scenario(scenario, folder)
    assert (summary.exit_code, summary.message, summary.missing) == (0, "", 0)
    log, direct = read_log(folder), closed_loop(Experiment.prepare(scenario))
    assert log_differences(direct, log) == []
    assert log.warnings == ()
    same_sensors(direct, log)
    return log


@pytest.mark.parametrize("name", LAWS)
def test_log_equals_the_direct_simulation(name: str, tmp_path: Path, log_differences: Differences) -> None:
    compare(load_scenario(name).with_values({"duration": 0.5}), tmp_path / "log", log_differences)


def test_slow_and_late_sensors_reach_law_and_log(tmp_path: Path, log_differences: Differences) -> None:
    data = dict(read_yaml(LIBRARY / "elbow_sensors.yaml"))
    late = {"delay": 1e-3, "rate": 500}
    data["sensors"] = {**data["sensors"], "link": {**data["sensors"]["link"], **late}}
    (tmp_path / "robot.yaml").write_text(yaml.safe_dump(data))
    changes = {"robot": str(tmp_path / "robot.yaml"), "duration": 0.4, "controller.observer.speed_filter": 5e-3}
    log = compare(load_scenario("elbow_state_feedback").with_values(changes), tmp_path / "log", log_differences)
    link, imu = log.other_series["link_states"], log.other_series["tool_imu"]
    assert np.array_equal(np.diff(link.stamp), np.full(len(link.stamp) - 1, 2_000_000))
    assert len(imu.stamp) == len(log.joint_states.stamp)


def test_lost_messages_change_nothing(tmp_path: Path, log_differences: Differences) -> None:
    loss = {"drop_fraction": 0.02}
    scenario = load_scenario("elbow_feedback_linearisation").with_values({"duration": 0.3})
    summary = run_scenario(scenario, tmp_path / "log", parameters={"plant": loss, "controller": loss})
    assert summary.exit_code == 0
    assert log_differences(closed_loop(Experiment.prepare(scenario)), read_log(tmp_path / "log")) == []


def test_gains_of_the_node_are_those_of_the_law(tmp_path: Path, log_differences: Differences) -> None:
    scenario = load_scenario("elbow_quasi_static").with_values({"duration": 0.3})
    gains = {"motor_1.bandwidth": 20.0, "motor_2.motor_bandwidth": 80.0, "observer.speed_filter": 2e-3}
    summary = run_scenario(scenario, tmp_path / "log", parameters={"controller": gains})
    assert summary.exit_code == 0
    wanted = scenario.with_values(
        {
            "controller.bandwidth": [20.0, 30.0],
            "controller.motor_bandwidth": [60.0, 80.0],
            "controller.observer.speed_filter": 2e-3,
        }
    )
    recorded = read_log(tmp_path / "log")
    assert log_differences(closed_loop(Experiment.prepare(wanted)), recorded) == []
    before = closed_loop(Experiment.prepare(scenario)).joint_commands
    assert before is not None
    assert recorded.joint_commands is not None
    assert not np.array_equal(before.effort, recorded.joint_commands.effort)  # type: ignore[arg-type]
