"""Sensors of a robot file beside the motor encoders: channels, units, and what is refused."""

from __future__ import annotations

from typing import Any

import pytest

from flexros.config.yaml_file import read_yaml
from flexros.control.context import LoopContext
from flexros.errors import InputError
from flexros.robot import load_robot
from flexros.robot.robot import LIBRARY, Robot, robot_from_data


def with_sensors(sensors: dict[str, Any], name: str = "elbow") -> Robot:
    data = dict(read_yaml(LIBRARY / f"{name}.yaml"))
    return robot_from_data({**data, "sensors": {**data.get("sensors", {}), **sensors}}, "test.yaml")


def test_shipped_robots_have_none_and_keep_their_fingerprint() -> None:
    robot = load_robot("four_mass")
    assert robot.further_sensors == ()
    assert "link" not in robot.spec.model_dump()["sensors"]


def test_channels_follow_joints_and_axes() -> None:
    robot = with_sensors(
        {
            "link": {"joints": ["motor_2"], "torque": {"noise": 0.5, "bias": -2.0}, "delay": 1e-3, "rate": 1000},
            "tool_imu": {"acceleration": {"noise": 0.02, "bias": [0.1, 0.2, 0.3], "axes": ["x", "z"]}},
        }
    )
    torque, acceleration = robot.further_sensors
    assert (torque.measurement, torque.indices, torque.noise, torque.bias) == ("joint_torque", (1,), 0.5, (-2.0,))
    assert (torque.delay, torque.rate, torque.topic) == (1e-3, 1000.0, "link_states")
    assert (acceleration.measurement, acceleration.indices) == ("tool_acceleration", (0, 2))
    assert acceleration.bias == (0.1, 0.3)
    assert robot.sensor_noise("joint torque") == 0.5
    assert robot.sensor_noise("link position") is None


def test_measurements_of_the_loop_follow_the_motors() -> None:
    robot = with_sensors({"link": {"position": {}}, "tool_imu": {"turning_rate": {"axes": ["y"]}}})
    layout = LoopContext(robot, 5e-4).measurements
    assert dict(layout.sizes) == {"motor_position": 2, "link_position": 2, "tool_turning_rate": 1}


@pytest.mark.parametrize(
    ("sensors", "text"),
    [
        ({"link": {}}, "position"),
        ({"link": {"joints": ["motor_3"], "position": {}}}, "motor_3"),
        ({"link": {"joints": ["motor_1", "motor_1"], "position": {}}}, "twice"),
        ({"link": {"position": {"noise": {"value": 1.0, "unit": "m"}}}}, "rad"),
        ({"link": {"torque": {"noise": -1.0}}}, "negative"),
        ({"link": {"position": {}, "rate": 0}}, "positive"),
        ({"tool_imu": {"acceleration": {"axes": ["z", "x"]}}}, "order"),
        ({"tool_imu": {"acceleration": {"noise": {"value": 1, "unit": "g"}}}}, "m/s2"),
        ({"tool_imu": {"turning_rate": {"bias": {"value": [0, 0, 1], "unit": "deg/s"}}}}, "rad/s"),
    ],
)
def test_what_does_not_fit_is_refused(sensors: dict[str, Any], text: str) -> None:
    with pytest.raises(InputError, match=text):
        with_sensors(sensors)


def test_a_law_that_needs_a_missing_sensor_is_refused() -> None:
    context = LoopContext(with_sensors({"link": {"joints": ["motor_1"], "position": {}}}), 5e-4)
    with pytest.raises(InputError, match=r"sensors\.link\.position\) at every joint.* has 1"):
        context.require("link_position")
    with pytest.raises(InputError, match=r"sensors\.tool_imu\.acceleration"):
        context.require("tool_acceleration")
