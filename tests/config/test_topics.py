from __future__ import annotations

import pytest
from pydantic import ValidationError

from flexros.config.location import data_folder
from flexros.config.topics import load_topics, read_qos, read_topics
from flexros.errors import InputError
from flexros.logs.messages.schemas import message_schema, signature

CONTRACT = {
    "joint_states": "sensor_msgs/msg/JointState",
    "joint_commands": "sensor_msgs/msg/JointState",
    "joint_reference": "sensor_msgs/msg/JointState",
    "tool_pose": "geometry_msgs/msg/PoseStamped",
    "tool_reference": "geometry_msgs/msg/PoseStamped",
    "link_states": "sensor_msgs/msg/JointState",
    "tool_imu": "sensor_msgs/msg/Imu",
}


def test_topics_of_the_contract_have_their_types_and_are_recorded():
    topics = load_topics()
    assert {name: topics[name].type for name in CONTRACT} == CONTRACT
    assert all(topics[name].recorded and topics[name].name == name for name in CONTRACT)


@pytest.mark.parametrize(
    ("name", "full_name", "type_name", "rate"),
    [
        ("joint_reference_ahead", "joint_reference_ahead", "trajectory_msgs/msg/JointTrajectory", None),
        ("joint_trajectory", "joint_trajectory", "trajectory_msgs/msg/JointTrajectory", None),
        ("clock", "/clock", "rosgraph_msgs/msg/Clock", 100.0),
        ("diagnostics", "/diagnostics", "diagnostic_msgs/msg/DiagnosticArray", 1.0),
    ],
)
def test_further_topics(name, full_name, type_name, rate):
    topic = load_topics()[name]
    assert (topic.name, topic.type, topic.rate) == (full_name, type_name, rate)


@pytest.mark.parametrize("name", sorted(load_topics()))
def test_fields_exist_in_the_message(name):
    """Every field with a unit is a field of the type, so that a renamed one cannot stay; behind `values` are keys."""
    topic = load_topics()[name]

    def names(fields, prefix=""):
        for field, kind, _ in fields:
            yield prefix + field
            if isinstance(kind, tuple):
                yield from names(kind, f"{prefix}{field}.")

    fields = {name.split(".values.")[0] + ".values" if ".values." in name else name for name in topic.fields}
    assert fields <= set(names(signature(topic.type, message_schema(topic.type).text)))


def test_loop_and_observer_profiles():
    profiles = read_qos(data_folder("msgs_config") / "qos.yaml")
    loop, observer = profiles["loop"], profiles["observer"]
    assert (loop.reliability, loop.history, loop.depth, loop.durability) == ("reliable", "keep_last", 200, "volatile")
    assert observer.reliability == "reliable"
    assert observer.depth >= 2000


def test_publishers_of_recorded_topics_hold_a_second():
    """keep_last overwrites even when reliable, at both ends."""
    for topic in load_topics().values():
        if topic.recorded and topic.rate is not None:
            assert topic.qos.depth >= topic.rate, topic.name


def test_nobody_consumes_what_it_produces():
    assert all(topic.producer not in topic.consumers for topic in load_topics().values())


def test_topics_are_frozen():
    with pytest.raises(ValidationError, match="frozen"):
        load_topics()["clock"].rate = 1.0


ROW = """
joint_states:
  description: x
  type: sensor_msgs/msg/JointState
  rate: 2000.0
  qos: loop
  recorded: true
  required: true
  producer: plant
  consumers: []
  fields: {position: {unit: rad, meaning: x}}
"""


def read(tmp_path, text):
    (tmp_path / "topics.yaml").write_text(text)
    return read_topics(tmp_path / "topics.yaml", read_qos(data_folder("msgs_config") / "qos.yaml"))


def test_subscriptions_default_to_the_profile_of_the_publisher(tmp_path):
    topic = read(tmp_path, ROW)["joint_states"]
    assert topic.qos is topic.subscription_qos


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            ("rate: 2000.0", "rate: -1"),
            r"topic joint_states: key 'rate' is -1, but input should be greater than 0; corr",
        ),
        (("rate: 2000.0", "rate: .nan"), r"topic joint_states: key 'rate' is nan, but input should be a finite number"),
        (("rate:", "rat:"), r"topic joint_states: unknown key 'rat': did you mean 'rate'\?"),
        (("producer: plant", "producer: plnt"), r"key 'producer' is 'plnt', but input should be 'plant', 'controller'"),
        (("qos: loop", "qos: lop"), r"unknown QoS profile 'lop' in .*joint_states, key qos: did you mean 'loop'"),
        (("sensor_msgs/msg/JointState", "JointState"), r"topic joint_states: key 'type' is 'JointState', but string"),
        (("unit: rad, ", ""), r"topic joint_states: key 'fields.position.unit' is missing; add it"),
    ],
)
def test_mistake_is_named_with_file_and_key(tmp_path, change, message):
    assert change[0] in ROW
    with pytest.raises(InputError, match=message) as caught:
        read(tmp_path, ROW.replace(*change))
    assert "topics.yaml" in str(caught.value)


def test_mistake_in_a_profile_is_named(tmp_path):
    text = (data_folder("msgs_config") / "qos.yaml").read_text().replace("depth: 2000", "depth: 0")
    (tmp_path / "qos.yaml").write_text(text)
    with pytest.raises(InputError, match=r"qos.yaml, profile observer: key 'depth' is 0, but input should be greater"):
        read_qos(tmp_path / "qos.yaml")
