"""Further sensors of a log, in the time of its record."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.logs.stamps import stamps_ns
from flexros.logs.time_series import ImuSeries, JointSeries, Log
from flexros.record.read import read_record
from flexros.record.record import Record
from flexros.robot import load_robot

N, T = 2000, 1e-3
NAMES = ("motor_1", "motor_2")
VALUES = np.random.default_rng(1).normal(size=(N, 2))
STAMP = stamps_ns(N, T)


def record_of(**series: object) -> Record:
    states = JointSeries(STAMP, NAMES, position=VALUES)
    log = Log(states, JointSeries(STAMP, NAMES, effort=VALUES), other_series=series)  # type: ignore[arg-type]
    return read_record(log, load_robot("elbow"), name="log")


def test_a_log_without_further_sensors_has_none() -> None:
    assert record_of().sensors == ()


def test_link_states_are_read_by_motor_and_quantity() -> None:
    link = JointSeries(STAMP, NAMES[::-1], position=VALUES[:, ::-1] + 0.1, effort=2 * VALUES[:, ::-1])
    found = {sensor.name: sensor for sensor in record_of(link_states=link).sensors}
    assert set(found) == {f"{quantity} of motor_{k}" for quantity in ("link position", "joint torque") for k in (1, 2)}
    second = found["link position of motor_2"]
    np.testing.assert_array_equal(second.values, VALUES[:, 1] + 0.1)
    np.testing.assert_allclose(second.time, np.arange(N) * T, atol=1e-12)
    assert second.motor is not None
    np.testing.assert_array_equal(second.motor, VALUES[:, 1])
    assert (second.unit, found["joint torque of motor_1"].unit) == ("rad", "Nm")
    assert found["joint torque of motor_1"].motor is None


def test_one_motor_may_have_a_sensor_alone() -> None:
    link = JointSeries(STAMP, ("motor_2",), effort=VALUES[:, :1])
    assert [sensor.name for sensor in record_of(link_states=link).sensors] == ["joint torque of motor_2"]


def test_axes_of_the_tool_that_were_not_measured_are_left_out() -> None:
    acceleration = np.full((N, 3), np.nan)
    acceleration[:, 1] = VALUES[:, 0]
    (sensor,) = record_of(tool_imu=ImuSeries(STAMP, "tool", acceleration=acceleration)).sensors
    assert (sensor.name, sensor.index, sensor.unit) == ("tool acceleration along y", 1, "m/s2")
    assert sensor.of_tool


def test_values_keep_the_times_of_their_own_clock() -> None:
    stamp = STAMP[::7] + 300_000
    (sensor,) = record_of(link_states=JointSeries(stamp, ("motor_1",), effort=VALUES[::7, :1])).sensors
    np.testing.assert_allclose(sensor.time, np.arange(0, N, 7)[: len(sensor.time)] * T + 3e-4, atol=1e-9)
    assert np.all(sensor.time <= (N - 1) * T)


def test_a_part_of_a_record_has_a_part_of_its_sensors() -> None:
    link = JointSeries(STAMP, NAMES, position=VALUES + 0.1)
    part = record_of(link_states=link).part(500, 800)
    sensor = part.sensors[0]
    np.testing.assert_allclose(sensor.time, np.arange(300) * T, atol=1e-9)
    np.testing.assert_array_equal(sensor.values, VALUES[500:800, 0] + 0.1)
    assert sensor.motor is not None
    assert len(sensor.motor) == 300


@pytest.mark.parametrize(("kept", "told"), [(5, "5 values"), (0, "")])
def test_sensors_with_too_few_values_are_left_out(kept: int, told: str) -> None:
    values = np.full((N, 1), np.nan)
    values[:kept, 0] = VALUES[:kept, 0]
    record = record_of(link_states=JointSeries(STAMP, ("motor_1",), effort=values))
    assert record.sensors == ()
    assert any(told in text for text in record.warnings) == bool(told)


def test_joints_that_the_robot_lacks_are_told() -> None:
    names = ("a", "b", "c")
    link = JointSeries(STAMP, names, effort=np.ones((N, 3)))
    record = record_of(link_states=link)
    assert record.sensors == ()
    assert any("link_states" in text and "not used" in text for text in record.warnings)


def test_a_sensor_that_stands_still_is_no_measurement() -> None:
    link = JointSeries(STAMP, NAMES, effort=np.zeros((N, 2)))
    assert replace(record_of(link_states=link)).sensors == ()


def test_joints_may_have_different_sensors() -> None:
    nothing = np.full(N, np.nan)
    link = JointSeries(
        STAMP,
        NAMES,
        position=np.column_stack([VALUES[:, 0] + 0.1, nothing]),
        effort=np.column_stack([nothing, VALUES[:, 1]]),
    )
    names = [sensor.name for sensor in record_of(link_states=link).sensors]
    assert names == ["link position of motor_1", "joint torque of motor_2"]


def test_a_link_position_without_that_of_its_motor_is_left_out() -> None:
    position = VALUES.copy()
    position[7, 0] = np.nan
    states = JointSeries(STAMP, NAMES, position=position)
    link = JointSeries(STAMP, ("motor_1",), position=VALUES[:, :1] + 0.1)
    log = Log(states, JointSeries(STAMP, NAMES, effort=VALUES), other_series={"link_states": link})
    (sensor,) = read_record(log, load_robot("elbow"), name="log").sensors
    assert sensor.motor is not None
    assert len(sensor.values) == len(sensor.motor) == N - 1
    assert np.isfinite(sensor.motor).all()


def test_a_copy_of_the_position_of_a_motor_is_no_sensor_of_its_link() -> None:
    record = record_of(link_states=JointSeries(STAMP, ("motor_1",), position=VALUES[:, :1]))
    assert record.sensors == ()
    assert any("is the position of its motor" in text for text in record.warnings)
