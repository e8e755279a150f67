from __future__ import annotations

import numpy as np
import pytest

from flexros.logs.cdr_cursor import MessageError
from flexros.logs.messages.pose_stamped import PoseStampedTemplate, read_pose_stamped_layout

TYPE = "geometry_msgs/msg/PoseStamped"
POSITION, ORIENTATION = (0.1, 0.2, 0.3), (0.0, 0.6, 0.0, 0.8)


def decoded(payload):
    layout = read_pose_stamped_layout(payload)
    message = np.frombuffer(payload, np.uint8)[None]
    (position,), (orientation,) = (layout.message.numbers(message, span) for span in range(2))
    return int(layout.message.stamps(message)[0]), layout.frame_id, tuple(position), tuple(orientation)


def oracle_message(store, stamp, frame_id):
    types = store.types
    header = types["std_msgs/msg/Header"](types["builtin_interfaces/msg/Time"](*divmod(stamp, 10**9)), frame_id)
    pose = types["geometry_msgs/msg/Pose"](
        types["geometry_msgs/msg/Point"](*POSITION), types["geometry_msgs/msg/Quaternion"](*ORIENTATION)
    )
    return types[TYPE](header, pose)


@pytest.mark.parametrize("frame_id", ["", "b", "base", "a_long_frame", "räum"])
def test_serialised_like_the_oracle(store, frame_id):
    expected = bytes(store.serialize_cdr(oracle_message(store, 3_000_000_007, frame_id), TYPE))
    assert PoseStampedTemplate(frame_id).fill(3_000_000_007, POSITION, ORIENTATION) == expected


@pytest.mark.parametrize("frame_id", ["", "base"])
def test_equal_to_ros(frame_id):
    serialization = pytest.importorskip("rclpy.serialization", reason="rclpy is not installed")
    from geometry_msgs.msg import PoseStamped

    message = PoseStamped()
    message.header.stamp.sec, message.header.frame_id = 9, frame_id
    message.pose.position.x, message.pose.position.y, message.pose.position.z = POSITION
    o = message.pose.orientation
    o.x, o.y, o.z, o.w = ORIENTATION
    ours = PoseStampedTemplate(frame_id).fill(9_000_000_000, POSITION, ORIENTATION)
    theirs = serialization.serialize_message(message)
    assert read_pose_stamped_layout(theirs).message.matches(np.frombuffer(ours, np.uint8)[None]).all()
    assert serialization.deserialize_message(ours, PoseStamped) == message
    assert decoded(theirs) == (9_000_000_000, frame_id, POSITION, ORIENTATION)


def test_arrays_and_tuples_give_the_same_bytes():
    template = PoseStampedTemplate("base")
    assert template.fill(1, np.array(POSITION), np.array(ORIENTATION)) == template.fill(1, POSITION, ORIENTATION)


def test_six_numbers_are_refused():
    with pytest.raises(ValueError, match=r"cannot hold the stamp 1, position \(0.1, 0.2\)"):
        PoseStampedTemplate("base").fill(1, POSITION[:2], ORIENTATION)


def test_big_endian_is_read(store):
    payload = bytes(store.serialize_cdr(oracle_message(store, 5, "base"), TYPE, little_endian=False))
    assert decoded(payload) == (5, "base", POSITION, ORIENTATION)


def test_truncated_message_is_refused():
    payload = PoseStampedTemplate("base").fill(1, POSITION, ORIENTATION)
    with pytest.raises(MessageError, match="inside pose, which needs 56 bytes"):
        read_pose_stamped_layout(payload[:-1])
