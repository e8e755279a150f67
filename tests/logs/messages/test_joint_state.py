from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flexros.logs.cdr_cursor import MessageError
from flexros.logs.messages.joint_state import (
    FIELDS,
    JointStateTemplate,
    JointStateView,
    joint_state_layout,
    read_joint_state_layout,
)

TYPE = "sensor_msgs/msg/JointState"
NAMES = st.lists(st.text("abcdefgh_äß", min_size=1, max_size=9), max_size=8, unique=True)


@settings(max_examples=60, deadline=None)
@given(NAMES, st.tuples(*[st.booleans()] * 3), st.text(max_size=9), st.integers(0, 2**31 * 10**9 - 1))
def test_serialised_like_the_oracle(store, joint_state, names, present, frame_id, stamp):
    frame_id = frame_id.replace("\0", "")
    rng = np.random.default_rng(len(names))
    values = {f: rng.normal(size=len(names)) for f, p in zip(FIELDS, present, strict=True) if p}
    filled = dict(zip(FIELDS, present, strict=True))
    payload = JointStateTemplate(names, frame_id=frame_id, **filled).fill(stamp, **values)
    assert payload == joint_state(stamp, names, frame_id=frame_id, **values)[1]


@pytest.mark.parametrize("n_joints", [1, 2, 3, 6])
@pytest.mark.parametrize("filled", [("position",), ("effort",), ("position", "velocity", "effort"), ()])
def test_equal_to_ros(n_joints, filled):
    serialization = pytest.importorskip("rclpy.serialization", reason="rclpy is not installed")
    from sensor_msgs.msg import JointState

    message = JointState()
    message.header.stamp.sec, message.header.stamp.nanosec = 7, 500
    message.header.frame_id = "base"
    message.name = [f"motor_{i + 1}" for i in range(n_joints)]
    values = {f: [0.1 * (i + 1) for i in range(n_joints)] for f in filled}
    for field, numbers in values.items():
        setattr(message, field, numbers)
    template = JointStateTemplate(message.name, frame_id="base", **dict.fromkeys(filled, True))
    ours = template.fill(7_000_000_500, **values)
    theirs = serialization.serialize_message(message)
    assert read_joint_state_layout(theirs).message.matches(np.frombuffer(ours, np.uint8)[None]).all()
    assert serialization.deserialize_message(ours, JointState) == message
    sample = JointStateView(message.name).unpack(theirs)
    assert sample.stamp_ns == 7_000_000_500
    assert [getattr(sample, f) for f in FIELDS] == [tuple(values[f]) if f in values else None for f in FIELDS]


def test_arrays_and_lists_give_the_same_bytes():
    template = JointStateTemplate(["a", "b"], effort=True)
    assert template.fill(5, effort=np.array([1.0, 2.0])) == template.fill(5, effort=[1.0, 2.0])


@pytest.mark.parametrize(
    "values",
    [{"position": [1.0]}, {"position": [1.0] * 3, "effort": [1.0]}, {"position": [1.0] * 2, "velocity": [0.0]}],
)
def test_wrong_number_of_values_is_refused(values):
    template = JointStateTemplate(["a", "b"], position=True, effort=True)
    with pytest.raises(ValueError, match=r"template of 2 joints with \('position', 'effort'\) cannot hold"):
        template.fill(5, **values)


def test_view_orders_joints_by_name(joint_state):
    _, payload = joint_state(3, ["c", "a", "b"], position=[3.0, 1.0, 2.0])
    sample = JointStateView(["a", "b", "c"]).unpack(payload)
    assert sample.position == (1.0, 2.0, 3.0)


def test_view_leaves_out_other_joints(joint_state):
    _, payload = joint_state(3, ["gripper", "a"], effort=[9.0, 1.0])
    assert JointStateView(["a"]).unpack(payload).effort == (1.0,)


def test_view_follows_a_sender_that_changes(joint_state):
    view = JointStateView(["a", "b"])
    first = joint_state(1, ["a", "b"], position=[1.0, 2.0])[1]
    second = joint_state(2, ["b", "a"], position=[2.0, 1.0], frame_id="x")[1]
    third = joint_state(3, ["a", "b"], velocity=[5.0, 6.0])[1]
    samples = [view.unpack(payload) for payload in (first, second, third, first)]
    assert [s.position for s in samples] == [(1.0, 2.0), (1.0, 2.0), None, (1.0, 2.0)]
    assert [s.velocity for s in samples] == [None, None, (5.0, 6.0), None]


def test_view_distinguishes_messages_of_equal_length(joint_state):
    view = JointStateView(["a", "b"])
    view.unpack(joint_state(1, ["a", "b"], position=[1.0, 2.0])[1])
    assert view.unpack(joint_state(1, ["b", "a"], position=[2.0, 1.0])[1]).position == (1.0, 2.0)


def test_view_reads_big_endian(store, joint_state):
    message, _ = joint_state(7_000_000_001, ["a", "b"], effort=[1.5, -2.0])
    payload = bytes(store.serialize_cdr(message, TYPE, little_endian=False))
    sample = JointStateView(["a", "b"]).unpack(payload)
    assert (sample.stamp_ns, sample.effort) == (7_000_000_001, (1.5, -2.0))


def test_missing_joint_is_named(joint_state):
    with pytest.raises(MessageError, match=r"lacks motor_2; it has motor_1, x$"):
        JointStateView(["motor_1", "motor_2"]).unpack(joint_state(1, ["motor_1", "x"])[1])


def test_a_failed_message_leaves_the_view_usable(joint_state):
    view = JointStateView(["a"])
    good = joint_state(1, ["a"], position=[4.0])[1]
    view.unpack(good)
    with pytest.raises(MessageError):
        view.unpack(good[:20])
    assert view.unpack(good).position == (4.0,)


def test_field_with_other_length_than_the_names_is_refused(joint_state):
    with pytest.raises(MessageError, match="has 2 names but 1 values in effort"):
        JointStateView(["a"]).unpack(joint_state(1, ["a", "b"], effort=[1.0])[1])


@settings(max_examples=100, deadline=None)
@given(cut=st.integers(0, 90), flip=st.integers(0, 89), value=st.integers(0, 255))
def test_damage_never_gives_another_error(joint_state, cut, flip, value):
    payload = bytearray(joint_state(1, ["motor_1"], [1.0], [2.0], [3.0], "base")[1])
    payload[flip % len(payload)] = value
    try:
        sample = JointStateView(["motor_1"]).unpack(bytes(payload[:cut]))
    except MessageError:
        return
    assert isinstance(sample.stamp_ns, int)


def test_claimed_size_is_not_allocated(joint_state):
    payload = bytearray(joint_state(1, [])[1])
    payload[-16:-12] = (2**32 - 1).to_bytes(4, "little")
    with pytest.raises(MessageError, match="claims 4294967295 entries of name"):
        JointStateView([]).unpack(bytes(payload))


def test_unknown_field_is_refused():
    with pytest.raises(ValueError, match=r"no field \['torque'\]"):
        joint_state_layout(["a"], ["torque"])


def test_padding_has_no_meaning(joint_state):
    """Fast CDR leaves the bytes between members uninitialised."""
    payload = bytearray(joint_state(1, ["ab", "c"], position=[1.0, 2.0], frame_id="base")[1])
    view = JointStateView(["ab", "c"])
    view.unpack(bytes(payload))
    padding = read_joint_state_layout(bytes(payload)).message.padding
    for begin, end in padding:
        payload[begin:end] = b"\xee" * (end - begin)
    learnt = view._known
    assert view.unpack(bytes(payload)).position == (1.0, 2.0)
    assert view._known is learnt, "the fast path must still be taken"
    assert len(padding) >= 3
