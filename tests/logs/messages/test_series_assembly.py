from __future__ import annotations

import numpy as np
import pytest

from flexros.logs.message_block import MESSAGE_HEADER, MessageBlock
from flexros.logs.messages.bulk_decode import TopicDecoder
from flexros.logs.messages.joint_state import JointStateCodec, JointStateTemplate
from flexros.logs.messages.pose_stamped import PoseStampedCodec, PoseStampedTemplate
from flexros.logs.messages.series_assembly import assemble_series


def decoder_of(codec, payloads):
    headers = np.zeros(len(payloads), MESSAGE_HEADER)
    headers["length"] = [len(p) + 22 for p in payloads]
    headers["log_time"] = 5000 + np.arange(len(payloads))
    decoder = TopicDecoder(codec.read)
    offsets = np.cumsum([0] + [len(p) for p in payloads])[:-1]
    decoder.add(MessageBlock(b"".join(payloads), headers, offsets), np.arange(len(payloads)))
    return decoder


def joints(*messages):
    """Assemble messages given as (stamp, {joint: position})."""
    payloads = [JointStateTemplate(list(q), position=True).fill(s, list(q.values())) for s, q in messages]
    return assemble(payloads)


def assemble(payloads):
    warnings = []
    codec = JointStateCodec()
    return assemble_series(codec, "/joint_states", decoder_of(codec, payloads), warnings), warnings


def test_joints_take_the_order_of_the_first_message():
    series, warnings = joints((1, {"b": 2.0, "a": 1.0}), (2, {"a": 3.0, "b": 4.0}), (3, {"a": 5.0, "b": 6.0}))
    assert series.names == ("b", "a")
    assert series.position.tolist() == [[2.0, 1.0], [4.0, 3.0], [6.0, 5.0]]
    assert series.velocity is None
    assert warnings == []


def test_messages_out_of_order_are_sorted():
    series, warnings = joints((3, {"a": 3.0}), (1, {"a": 1.0}), (2, {"a": 2.0}))
    assert series.stamp.tolist() == [1, 2, 3]
    assert series.position[:, 0].tolist() == [1.0, 2.0, 3.0]
    assert warnings == ["/joint_states: messages are not in the order of their stamps, they were sorted"]


def test_equal_repeats_are_dropped_and_counted():
    series, warnings = joints((1, {"a": 1.0}), (2, {"a": 2.0}), (2, {"a": 2.0}), (2, {"a": 2.0}), (3, {"a": np.nan}))
    assert series.stamp.tolist() == [1, 2, 3]
    assert "/joint_states: 2 repeated messages (same stamp, same values) were dropped" in warnings


def test_repeats_with_other_values_keep_the_first():
    series, warnings = joints((1, {"a": 1.0}), (2, {"a": 2.0}), (2, {"a": 2.0}), (2, {"a": 9.0}))
    assert series.position[:, 0].tolist() == [1.0, 2.0]
    assert "/joint_states: 1 repeated messages (same stamp, same values) were dropped" in warnings
    assert "/joint_states: 1 messages repeat a stamp with other values, the first of each was kept" in warnings


def test_repeats_of_missing_numbers_are_equal():
    _, warnings = joints((1, {"a": np.nan}), (1, {"a": np.nan}))
    assert "/joint_states: 1 repeated messages (same stamp, same values) were dropped" in warnings


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_numbers_that_are_not_finite_are_warned_of(value):
    _, warnings = joints((1, {"a": 1.0, "b": value}), (2, {"a": 1.0, "b": 2.0}))
    assert warnings == ["/joint_states: position is not a finite number in 1 of 2 messages"]


@pytest.mark.parametrize(("value", "told"), [(1.0, 0), (np.nan, 1)])
def test_a_joint_without_any_number_is_told_only_where_no_joint_has_one(value, told):
    _, warnings = joints((1, {"a": value, "b": np.nan}), (2, {"a": value, "b": np.nan}))
    assert len(warnings) == told


def test_messages_of_other_joints_are_left_out():
    series, warnings = joints((1, {"gripper": 9.0}), (1, {"a": 1.0}), (2, {"a": 2.0}))
    assert series.names == ("a",)
    assert series.position[:, 0].tolist() == [1.0, 2.0]
    assert warnings == ["/joint_states: 1 of 3 messages have other joint names than the rest, left out"]


def test_field_that_is_filled_only_at_times():
    with_effort = JointStateTemplate(["a"], position=True, effort=True)
    payloads = [JointStateTemplate(["a"], position=True).fill(1, [1.0]), with_effort.fill(2, [2.0], effort=[5.0])]
    series, warnings = assemble(payloads)
    np.testing.assert_array_equal(series.effort, [[np.nan], [5.0]])
    assert warnings == ["/joint_states: effort is not a finite number in 1 of 2 messages"]


def test_without_stamps_the_log_time_is_used():
    series, warnings = joints((0, {"a": 1.0}), (0, {"a": 2.0}))
    assert series.stamp.tolist() == [5000, 5001]
    assert warnings == ["/joint_states: no message has a header.stamp, the log time is used instead"]


def test_log_times_are_kept_in_addition_to_the_stamps_and_sorted_with_them():
    series, _ = joints((3, {"a": 3.0}), (1, {"a": 1.0}), (2, {"a": 2.0}), (2, {"a": 2.0}))
    assert series.stamp.tolist() == [1, 2, 3]
    assert series.received.tolist() == [5001, 5002, 5000]


def test_log_times_that_are_the_stamps_are_not_kept():
    series, _ = joints((5000, {"a": 3.0}), (5001, {"a": 1.0}))
    assert series.received is None


def test_damaged_messages_are_reported_with_the_first_reason():
    series, warnings = assemble([JointStateTemplate(["a"], position=True).fill(1, [1.0]), b"\0\1"])
    assert len(series.stamp) == 1
    assert warnings[0].startswith(
        "/joint_states: 1 of 2 messages are damaged and were left out (the first: a message begins"
    )


def test_nothing_but_damage_gives_no_series():
    assert assemble([b"x", b"y"])[0] is None


def poses(*frames):
    payloads = [PoseStampedTemplate(f).fill(k + 1, (k, 0.0, 1.0), (0.0, 0.0, 0.0, 1.0)) for k, f in enumerate(frames)]
    warnings = []
    codec = PoseStampedCodec()
    return assemble_series(codec, "/tool_pose", decoder_of(codec, payloads), warnings), warnings


def test_poses():
    series, warnings = poses("base", "base", "base")
    assert series.frame_id == "base"
    assert series.position.tolist() == [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [2.0, 0.0, 1.0]]
    assert series.orientation.tolist() == [[0.0, 0.0, 0.0, 1.0]] * 3
    assert warnings == []


def test_log_times_of_poses_are_kept():
    series, _ = poses("base", "base")
    assert series.received.tolist() == [5000, 5001]


def test_poses_in_other_frames_are_left_out():
    series, warnings = poses("base", "camera", "base")
    assert series.stamp.tolist() == [1, 3]
    assert warnings == ["/tool_pose: 1 of 3 messages have other frames than the rest, left out"]
