from __future__ import annotations

import itertools

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.logs.cdr_cursor import MessageError
from flexros.logs.messages.joint_trajectory import (
    FIELDS,
    JointTrajectoryChunk,
    read_joint_trajectory,
    serialise_joint_trajectory,
)

TYPE = "trajectory_msgs/msg/JointTrajectory"


def make_chunk(n_points, names, filled, frame_id=""):
    rng = np.random.default_rng(n_points)
    values = {field: rng.normal(size=(n_points, len(names))) for field in filled}
    time = 3_999_999_000 + 500 * np.arange(n_points)
    return JointTrajectoryChunk(1_000_000_007, names, time, frame_id=frame_id, **values)


def assert_same_chunk(a, b):
    assert (a.stamp_ns, a.names, a.frame_id) == (b.stamp_ns, b.names, b.frame_id)
    np.testing.assert_array_equal(a.time_from_start, b.time_from_start)
    for field in FIELDS:
        left, right = getattr(a, field), getattr(b, field)
        assert (left is None) == (right is None)
        if left is not None:
            np.testing.assert_array_equal(left, right)


ALL_FILLED = [c for r in range(5) for c in itertools.combinations(FIELDS, r)]


@pytest.mark.parametrize("filled", ALL_FILLED)
@pytest.mark.parametrize("names", [("a",), ("motor_1", "motor_22"), ("x", "yy", "zzz")])
def test_serialised_like_the_oracle_and_read_back(store, names, filled):
    for n_points in (1, 2, 5):
        chunk = make_chunk(n_points, names, filled)
        payload = serialise_joint_trajectory(chunk)
        assert bytes(store.serialize_cdr(store.deserialize_cdr(payload, TYPE), TYPE)) == payload
        points = store.deserialize_cdr(payload, TYPE).points
        for field in filled:
            np.testing.assert_array_equal([getattr(p, field) for p in points], getattr(chunk, field))
        times = [p.time_from_start.sec * 10**9 + p.time_from_start.nanosec for p in points]
        assert times == chunk.time_from_start.tolist()
        assert_same_chunk(read_joint_trajectory(payload), chunk)


def test_equal_to_ros():
    serialization = pytest.importorskip("rclpy.serialization", reason="rclpy is not installed")
    from trajectory_msgs.msg import JointTrajectory

    chunk = make_chunk(20, ("motor_1", "motor_2"), ("positions", "velocities", "effort"), "base")
    ours = serialise_joint_trajectory(chunk)
    message = serialization.deserialize_message(ours, JointTrajectory)
    theirs = serialization.serialize_message(message)
    assert len(message.points) == 20
    assert list(message.points[7].positions) == chunk.positions[7].tolist()
    assert len(theirs) >= len(ours)
    assert_same_chunk(read_joint_trajectory(theirs), chunk)


def test_no_points(store):
    chunk = make_chunk(0, ("a",), ())
    assert len(store.deserialize_cdr(serialise_joint_trajectory(chunk), TYPE).points) == 0
    assert_same_chunk(read_joint_trajectory(serialise_joint_trajectory(chunk)), chunk)


def test_big_endian(store):
    chunk = make_chunk(4, ("a", "b"), ("positions", "effort"))
    message = store.deserialize_cdr(serialise_joint_trajectory(chunk), TYPE)
    assert_same_chunk(read_joint_trajectory(bytes(store.serialize_cdr(message, TYPE, little_endian=False))), chunk)


def test_joints_in_the_order_wanted():
    chunk = make_chunk(3, ("a", "b"), ("positions",))
    swapped = chunk.in_order(("b", "a"))
    np.testing.assert_array_equal(swapped.positions, chunk.positions[:, ::-1])
    assert swapped.names == ("b", "a")
    assert swapped.effort is None


def test_missing_joint_is_named():
    with pytest.raises(MessageError, match="lacks c; it has a, b"):
        make_chunk(3, ("a", "b"), ("positions",)).in_order(("a", "c"))


def test_points_that_differ_in_their_fields_are_refused(store):
    chunk = make_chunk(3, ("a", "b"), ("positions", "effort"))
    message = store.deserialize_cdr(serialise_joint_trajectory(chunk), TYPE)
    message.points[1].effort = np.ones(4)
    with pytest.raises(MessageError, match="differ in the fields that they fill; fill a field in all or in none"):
        read_joint_trajectory(bytes(store.serialize_cdr(message, TYPE)))


def test_first_point_with_wrong_size_is_refused(store):
    message = store.deserialize_cdr(serialise_joint_trajectory(make_chunk(1, ("a", "b"), ("positions",))), TYPE)
    message.points[0].velocities = np.ones(3)
    with pytest.raises(MessageError, match=r"2 joint names but 3 values in points\[0\].velocities"):
        read_joint_trajectory(bytes(store.serialize_cdr(message, TYPE)))


def test_claimed_number_of_points_is_not_allocated():
    payload = serialise_joint_trajectory(make_chunk(2, ("a",), ("positions",)))
    at = payload.index(b"a\0") + 4
    damaged = payload[:at] + (2**31).to_bytes(4, "little") + payload[at + 4 :]
    with pytest.raises(MessageError, match="inside 2147483647 points"):
        read_joint_trajectory(damaged)


def test_truncated_message_is_refused():
    payload = serialise_joint_trajectory(make_chunk(5, ("a",), ("positions",)))
    for cut in range(len(payload)):
        with pytest.raises(MessageError):
            read_joint_trajectory(payload[:cut])


def test_wrong_shape_is_refused():
    with pytest.raises(InputError, match=r"effort has shape \(2, 1\), allowed is \(3, 1\)"):
        JointTrajectoryChunk(0, ("a",), np.arange(3), effort=np.zeros((2, 1)))
