"""Messages of further sensors: what a plant writes, a controller reads, at any rate and in any order."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.errors import RunError
from flexros.logs.messages.imu import ImuTemplate
from flexros.logs.messages.joint_state import JointStateTemplate
from flexros.logs.stamps import stamp_ns
from flexros.robot import load_robot
from flexros.robot.robot import Robot, robot_from_data
from flexros.simulate.sensor_timing import SensorTiming
from flexros_nodes.protocol.sensor_messages import SensorReader, SensorWriter, sensor_topics

T = 5e-4
VALUES = np.array([0.1, 0.2, 30.0, 40.0, 1.5, -9.0, 0.7])
"""Link positions, joint torques, accelerations along x and z, turning rate about y."""


def robot(rate: float | None = None) -> Robot:
    data = load_robot("elbow_sensors").spec.model_dump()
    data["sensors"]["link"]["rate"] = rate
    return robot_from_data(data, "test")


def pair(given: Robot) -> tuple[SensorWriter, SensorReader]:
    timing = SensorTiming.of(given.further_sensors, T)
    topics = sensor_topics(given, timing)
    return SensorWriter(topics), SensorReader(topics, timing.size)


def test_topics_group_the_sensors_of_the_robot_file() -> None:
    given = robot(rate=500)
    link, imu = sensor_topics(given, SensorTiming.of(given.further_sensors, T))
    assert (link.topic, link.joints, link.period, link.begins) == ("link_states", ("motor_1", "motor_2"), 4, (0, 2))
    assert (imu.topic, imu.joints, imu.period, imu.begins) == ("tool_imu", (), 1, (4, 6))


def test_a_reader_gets_what_a_writer_sends() -> None:
    writer, reader = pair(robot())
    stamp = stamp_ns(0, T)
    messages = writer.fill(0, stamp, VALUES)
    assert reader.values(0, stamp) is None
    reader.take("tool_imu", messages["tool_imu"])
    assert reader.values(0, stamp) is None
    reader.take("link_states", messages["link_states"])
    assert reader.values(0, stamp) == VALUES.tolist()


def test_a_slow_sensor_is_sent_seldom_and_held() -> None:
    writer, reader = pair(robot(rate=500))
    for sample in range(6):
        stamp = stamp_ns(sample, T)
        messages = writer.fill(sample, stamp, VALUES + sample)
        assert ("link_states" in messages) == (sample % 4 == 0)
        for name, message in messages.items():
            reader.take(name, message)
            reader.take(name, message)  # repeated
        found = reader.values(sample, stamp)
        assert found is not None
        held = sample - sample % 4
        assert found == [*(VALUES[:4] + held), *(VALUES[4:] + sample)]


def test_a_late_repeat_does_not_bring_an_old_value_back() -> None:
    writer, reader = pair(robot(rate=500))
    old = writer.fill(0, stamp_ns(0, T), VALUES)["link_states"]
    for sample in range(5):
        for name, message in writer.fill(sample, stamp_ns(sample, T), VALUES + sample).items():
            reader.take(name, message)
        reader.values(sample, stamp_ns(sample, T))
    reader.take("link_states", old)
    reader.take("tool_imu", writer.fill(5, stamp_ns(5, T), VALUES)["tool_imu"])
    found = reader.values(5, stamp_ns(5, T))
    assert found is not None
    assert found[0] == VALUES[0] + 4


def test_other_senders_may_name_the_joints_in_any_order_but_must_fill_the_fields() -> None:
    _, reader = pair(robot())
    stamp = stamp_ns(0, T)
    turned = JointStateTemplate(["motor_2", "motor_1"], position=True, effort=True)
    reader.take("link_states", turned.fill(stamp, position=[0.2, 0.1], effort=[40.0, 30.0]))
    imu = ImuTemplate("sensor", acceleration=True, turning_rate=True)
    reader.take("tool_imu", imu.fill(stamp, [1.5, 0.0, -9.0], [0.0, 0.7, 0.0]))
    assert reader.values(0, stamp) == VALUES.tolist()
    with pytest.raises(RunError, match="effort is empty"):
        reader.take(
            "link_states", JointStateTemplate(["motor_1", "motor_2"], position=True).fill(stamp + 1, [0.0, 0.0])
        )
    with pytest.raises(RunError, match="turning_rate"):
        reader.take("tool_imu", ImuTemplate("sensor", acceleration=True).fill(stamp + 1, [1.0, 2.0, 3.0]))
    with pytest.raises(RunError, match="acceleration"):
        reader.take("tool_imu", imu.fill(stamp + 1, [np.nan, 0.0, -9.0], [0.0, 0.7, 0.0]))
