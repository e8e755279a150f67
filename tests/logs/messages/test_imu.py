from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.logs.cdr_cursor import MessageError
from flexros.logs.messages.imu import ImuCodec, ImuTemplate, ImuView, read_imu_layout
from flexros.logs.reader import read_log
from flexros.logs.time_series import ImuSeries, JointSeries
from flexros.logs.write_log import write_log

TYPE = "sensor_msgs/msg/Imu"
STAMP = np.array([3_000_000_007, 4_000_000_000])
ACCELERATION = np.array([[0.1, 0.2, 9.81], [0.3, np.nan, 9.7]])
RATE = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])


def oracle_message(store, frame_id):
    types = store.types
    header = types["std_msgs/msg/Header"](types["builtin_interfaces/msg/Time"](3, 7), frame_id)
    vector, none = types["geometry_msgs/msg/Vector3"], np.array([-1.0] + [0.0] * 8)
    quaternion = types["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 0.0)
    return types[TYPE](header, quaternion, none, vector(0.0, 0.0, 0.0), none, vector(*ACCELERATION[0]), np.zeros(9))


@pytest.mark.parametrize("frame_id", ["", "tool", "räum"])
def test_serialised_like_the_oracle(store, frame_id):
    expected = bytes(store.serialize_cdr(oracle_message(store, frame_id), TYPE))
    layout, numbers = ImuCodec().columns(ImuSeries(STAMP[:1], frame_id, ACCELERATION[:1]))
    assert layout.serialise(STAMP[:1], numbers)[0].tobytes() == expected
    assert ImuCodec().serialiser()(oracle_message(store, frame_id)) == expected
    assert read_imu_layout(expected).frame_id == frame_id


def test_truncated_message_is_refused():
    with pytest.raises(MessageError):
        read_imu_layout(bytes(100))


def test_sensors_of_link_and_tool_survive_a_log(tmp_path, make_log):
    imu = ImuSeries(STAMP, "tool", ACCELERATION, None)
    link = JointSeries(STAMP, ("motor_1",), position=np.ones((2, 1)), effort=np.zeros((2, 1)))
    write_log(replace(make_log(), other_series={"tool_imu": imu, "link_states": link}), tmp_path / "log")
    log = read_log(tmp_path / "log")
    read = log.series("tool_imu")
    np.testing.assert_array_equal(read.acceleration, ACCELERATION)
    assert read.turning_rate is None
    assert read.frame_id == "tool"
    np.testing.assert_array_equal(log.series("link_states").position, link.position)
    assert log.series("link_states").velocity is None


def test_turning_rate_alone():
    _, numbers = ImuCodec().columns(ImuSeries(STAMP, "tool", None, RATE))
    np.testing.assert_array_equal(numbers[0][:, 13:16], RATE)
    assert (numbers[0][:, 28] == -1).all()


def test_template_and_view_agree_with_the_codec() -> None:
    template = ImuTemplate("tool", acceleration=True)
    message = template.fill(1_000_500_000, [1.0, np.nan, 3.0])
    sample = ImuView().unpack(message)
    assert (sample.stamp_ns, sample.turning_rate) == (1_000_500_000, None)
    assert sample.acceleration is not None
    assert np.array_equal(sample.acceleration, [1.0, np.nan, 3.0], equal_nan=True)
    series = ImuSeries(np.array([1_000_500_000]), "tool", np.array([[1.0, np.nan, 3.0]]))
    layout, columns = ImuCodec().columns(series)
    assert layout.serialise(series.stamp, columns)[0].tobytes() == message


def test_view_reads_messages_of_other_frames() -> None:
    view = ImuView()
    for frame in ("a", "another_frame", "a"):
        message = ImuTemplate(frame, acceleration=True, turning_rate=True).fill(7, [1.0, 2.0, 3.0], [4.0, 5.0, 6.0])
        assert view.unpack(message) == (7, (1.0, 2.0, 3.0), (4.0, 5.0, 6.0))
    with pytest.raises(MessageError):
        view.unpack(b"\0" * 20)
