from __future__ import annotations

import numpy as np
import pytest
from mcap.records import Schema
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from flexros.errors import InputError
from flexros.logs.cdr_cursor import MessageError
from flexros.logs.messages.foreign_definition import is_common, translator
from flexros.logs.messages.joint_state import JointStateCodec, JointStateView
from flexros.logs.messages.pose_stamped import PoseStampedCodec, PoseStampedTemplate
from flexros.logs.messages.schemas import message_schema

JOINT_STATE = "sensor_msgs/msg/JointState"
POSE = "geometry_msgs/msg/PoseStamped"
FOREIGN = (
    message_schema(JOINT_STATE)
    .text.replace("string[] name", "uint8 mode\nstring[] name")
    .replace("float64[] velocity\n", "float32[] effort\n")
    .replace("float64[] effort\n", "")
)
IDL = """module sensor_msgs { module msg {
struct Stamp { int32 sec; unsigned long nanosec; };
struct Header { sensor_msgs::msg::Stamp stamp; string frame_id; };
struct JointState { sensor_msgs::msg::Header header; sequence<string> name; sequence<double> position; };
}; };
"""


def schema(text, name=JOINT_STATE, encoding="ros2msg"):
    return Schema(id=1, name=name, encoding=encoding, data=text.encode())


@pytest.mark.parametrize("name", [JOINT_STATE, POSE])
def test_common_definition_is_recognised(name):
    assert is_common(schema(message_schema(name).text, name))
    assert is_common(schema("# with a comment\n" + message_schema(name).text, name))


@pytest.mark.parametrize(("text", "encoding"), [(FOREIGN, "ros2msg"), (IDL, "ros2idl"), ("Header header", "ros2msg")])
def test_other_definitions_are_recognised(text, encoding):
    assert not is_common(schema(text, encoding=encoding))


def test_message_of_another_definition():
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(FOREIGN, JOINT_STATE))
    types = store.types
    header = types["std_msgs/msg/Header"](types["builtin_interfaces/msg/Time"](3, 4), "base")
    message = types[JOINT_STATE](header, 7, ["b", "a"], np.array([2.0, 1.0]), np.array([0.5, 0.25], np.float32))
    payload = translator(JointStateCodec(), schema(FOREIGN), "x.mcap")(bytes(store.serialize_cdr(message, JOINT_STATE)))
    sample = JointStateView(["a", "b"]).unpack(payload)
    assert sample == (3_000_000_004, (1.0, 2.0), None, (0.25, 0.5))


def test_definition_in_idl(joint_state):
    _, payload = joint_state(5, ["a"], position=[1.5])
    without_velocity_and_effort = payload[:-8]
    translated = translator(JointStateCodec(), schema(IDL, encoding="ros2idl"), "x.mcap")(without_velocity_and_effort)
    assert JointStateView(["a"]).unpack(translated) == (5, (1.5,), None, None)


def test_pose_of_another_definition(store):
    text = message_schema(POSE).text.replace("geometry_msgs/Pose pose", "geometry_msgs/Pose pose\nfloat64 confidence")
    foreign = get_typestore(Stores.EMPTY)
    foreign.register(get_types_from_msg(text, POSE))
    types = foreign.types
    header = types["std_msgs/msg/Header"](types["builtin_interfaces/msg/Time"](1, 2), "base")
    pose = types["geometry_msgs/msg/Pose"](
        types["geometry_msgs/msg/Point"](1.0, 2.0, 3.0), types["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.6, 0.8)
    )
    payload = bytes(foreign.serialize_cdr(types[POSE](header, pose, 0.5), POSE))
    translated = translator(PoseStampedCodec(), schema(text, POSE), "x.mcap")(payload)
    assert translated == PoseStampedTemplate("base").fill(1_000_000_002, (1.0, 2.0, 3.0), (0.0, 0.0, 0.6, 0.8))


def test_message_that_does_not_fit():
    with pytest.raises(MessageError, match="it does not fit its definition"):
        translator(JointStateCodec(), schema(FOREIGN), "x.mcap")(b"\0\1\0\0abc")


@pytest.mark.parametrize(
    ("text", "encoding", "message"),
    [
        ("float64", "ros2msg", r"x.mcap: the definition of sensor_msgs/msg/JointState cannot be read \("),
        ("module {", "ros2idl", r"x.mcap: the definition of sensor_msgs/msg/JointState cannot be read \("),
        ("x", "protobuf", r"is in 'protobuf', allowed are ros2msg and ros2idl"),
    ],
)
def test_unreadable_definition_is_named(text, encoding, message):
    with pytest.raises(InputError, match=message):
        translator(JointStateCodec(), schema(text, encoding=encoding), "x.mcap")
