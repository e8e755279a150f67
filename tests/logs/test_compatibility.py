"""Our logs in the hands of others, and theirs in ours."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from mcap_ros2.writer import Writer as Ros2Writer
from rosbags.highlevel import AnyReader
from rosbags.interfaces import QosDurability, QosHistory, QosReliability
from rosbags.rosbag2 import Reader, StoragePlugin, Writer

from flexros.logs.messages.joint_state import JointStateTemplate
from flexros.logs.messages.pose_stamped import PoseStampedTemplate
from flexros.logs.messages.schemas import message_schema
from flexros.logs.reader import read_log
from flexros.logs.write_log import write_log

TOPICS = ["/joint_states", "/joint_commands", "/joint_reference", "/tool_pose", "/tool_reference"]
JOINT_STATE, POSE = "sensor_msgs/msg/JointState", "geometry_msgs/msg/PoseStamped"


@pytest.fixture
def log(make_log):
    return make_log(1200)


@pytest.fixture
def folder(tmp_path, log):
    write_log(log, tmp_path / "log")
    return tmp_path / "log"


def test_rosbags_reader_sees_topics_counts_and_qos(folder, log):
    with Reader(folder) as reader:
        assert [c.topic for c in reader.connections] == TOPICS
        assert {c.msgcount for c in reader.connections} == {1200}
        assert reader.message_count == 6000
        assert reader.start_time == 10**9
        assert reader.end_time == log.joint_states.stamp[-1] + 1
        assert reader.ros_distro == "jazzy"
        for connection in reader.connections:
            assert connection.digest == message_schema(connection.msgtype).type_hash
            (qos,) = connection.ext.offered_qos_profiles
            assert (qos.history, qos.depth) == (QosHistory.KEEP_LAST, 2000)
            assert (qos.reliability, qos.durability) == (QosReliability.RELIABLE, QosDurability.VOLATILE)
            assert (qos.deadline.sec, qos.deadline.nsec) == (9223372036, 854775807)


def test_rosbags_any_reader_decodes_our_values(folder, log):
    with AnyReader([folder]) as reader:
        for k, (connection, time, raw) in enumerate(reader.messages()):
            message = reader.deserialize(raw, connection.msgtype)
            row = k // 5
            stamp = log.joint_states.stamp[row]
            assert (connection.topic, time) == (TOPICS[k % 5], stamp)
            assert message.header.stamp.sec * 10**9 + message.header.stamp.nanosec == stamp
            if connection.topic == "/joint_reference":
                np.testing.assert_array_equal(message.effort, log.joint_reference.effort[row])
            if connection.topic == "/tool_pose":
                assert message.header.frame_id == "base"
                assert message.pose.orientation.w == log.tool_pose.orientation[row, 3]
    assert k == 5999


def test_single_file_in_rosbags_any_reader(folder):
    with AnyReader([folder / "log_0.mcap"]) as reader:
        assert reader.message_count == 6000


def test_mcap_ros2_decodes_our_values(folder, log):
    with (folder / "log_0.mcap").open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        assert reader.get_header().profile == "ros2"
        assert [m.name for m in reader.iter_metadata()] == ["rosbag2"]
        assert "ros_distro: jazzy" in next(iter(reader.iter_metadata())).metadata["serialized_metadata"]
        channels = reader.get_summary().channels.values()
        assert all(set(c.metadata) == {"offered_qos_profiles", "topic_type_hash"} for c in channels)
        commands = [m.decoded_message.effort for m in reader.iter_decoded_messages(topics=["/joint_commands"])]
    np.testing.assert_array_equal(commands, log.joint_commands.effort)


def test_log_of_rosbags_writer(tmp_path, store, log, assert_same_log):
    templates = {
        "/joint_states": JointStateTemplate(log.joint_states.names, position=True),
        "/tool_pose": PoseStampedTemplate("base"),
    }
    with Writer(tmp_path / "log", version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        connections = {
            "/joint_states": writer.add_connection("/joint_states", JOINT_STATE, typestore=store),
            "/tool_pose": writer.add_connection("/tool_pose", POSE, typestore=store),
        }
        for k in reversed(range(1200)):
            stamp = int(log.joint_states.stamp[k])
            pose = templates["/tool_pose"].fill(stamp, log.tool_pose.position[k], log.tool_pose.orientation[k])
            writer.write(connections["/tool_pose"], stamp + 123, pose)
            state = templates["/joint_states"].fill(stamp, log.joint_states.position[k])
            writer.write(connections["/joint_states"], stamp + 77, state)
    again = read_log(tmp_path / "log")
    np.testing.assert_array_equal(again.joint_states.position, log.joint_states.position)
    np.testing.assert_array_equal(again.tool_pose.orientation, log.tool_pose.orientation)
    assert again.joint_commands is None
    assert again.provenance == {}


def test_log_of_mcap_ros2_writer(tmp_path, log):
    path: Path = tmp_path / "foreign.mcap"
    with path.open("wb") as stream:
        writer = Ros2Writer(stream)
        schema = writer.register_msgdef(JOINT_STATE, message_schema(JOINT_STATE).text)
        for k in range(300):
            sec, nanosec = divmod(int(log.joint_states.stamp[k]), 10**9)
            header = SimpleNamespace(stamp=SimpleNamespace(sec=sec, nanosec=nanosec), frame_id="")
            message = SimpleNamespace(
                header=header,
                name=list(reversed(log.joint_states.names)) if k % 2 else list(log.joint_states.names),
                position=log.joint_states.position[k][:: -1 if k % 2 else 1].tolist(),
                velocity=[],
                effort=[],
            )
            writer.write_message("/joint_states", schema, message, log_time=k)
        writer.finish()
    again = read_log(path)
    np.testing.assert_array_equal(again.joint_states.position, log.joint_states.position[:300])
    assert again.joint_states.names == log.joint_states.names
    assert again.warnings == ()


def test_log_of_rclpy_serialisation(tmp_path, log):
    """Messages of a recorder in Python: padding and tail are uninitialised."""
    serialization = pytest.importorskip("rclpy.serialization", reason="rclpy is not installed")
    from mcap.writer import Writer as McapWriter
    from sensor_msgs.msg import JointState

    path = tmp_path / "rclpy.mcap"
    with path.open("wb") as stream:
        writer = McapWriter(stream)
        writer.start(profile="ros2")
        schema = writer.register_schema(JOINT_STATE, "ros2msg", message_schema(JOINT_STATE).text.encode())
        channel = writer.register_channel("/joint_states", "cdr", schema)
        for k in range(200):
            message = JointState(name=["a", "bc", "def"], position=[k, k + 1.0, k + 2.0])
            message.header.frame_id = "base"
            message.header.stamp.sec = k + 1
            writer.add_message(channel, k, serialization.serialize_message(message), k)
        writer.finish()
    again = read_log(path)
    np.testing.assert_array_equal(again.joint_states.position, np.arange(200.0)[:, None] + np.arange(3))
    assert again.warnings == ()
