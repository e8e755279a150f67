"""Recorded topics of a file, and those that cannot be played."""

from __future__ import annotations

import pytest
from mcap.records import Channel, Schema

from flexros.logs.replay.recorded_topic import absolute_name, name_problem, recorded_topic, type_in_full


def channel(topic: str = "/a", encoding: str = "cdr", qos: str = "") -> Channel:
    return Channel(id=1, topic=topic, message_encoding=encoding, schema_id=1, metadata={"offered_qos_profiles": qos})


def schema(name: str = "std_msgs/msg/String", text: str = "string data\n", encoding: str = "ros2msg") -> Schema:
    return Schema(id=1, name=name, encoding=encoding, data=text.encode())


@pytest.mark.parametrize(
    ("given", "full"),
    [
        ("std_msgs/msg/String", "std_msgs/msg/String"),
        ("std_msgs/String", "std_msgs/msg/String"),
        ("a_b/srv/Do_Event", "a_b/srv/Do_Event"),
        ("String", ""),
        ("os.path/msg/String", ""),
        ("__main__/msg/String", ""),
    ],
)
def test_types_are_written_in_full(given: str, full: str) -> None:
    assert type_in_full(given) == full


def test_a_common_topic_can_be_played() -> None:
    topic = recorded_topic(channel("a/b/"), schema("std_msgs/String"))
    assert (topic.name, topic.type, topic.refusal) == ("/a/b", "std_msgs/msg/String", "")
    assert not topic.best_effort
    assert not topic.latched


@pytest.mark.parametrize(
    ("topic", "of_type", "why"),
    [
        (channel(), None, "the file does not define its type"),
        (channel(), schema("Plain"), "its type 'Plain' is not a ROS 2 type"),
        (channel(encoding="json"), schema(), "it is encoded as 'json', nodes of ROS 2 accept cdr"),
        (channel(), schema(text="float64 data\n"), "its definition of std_msgs/msg/String is not that of ROS 2 Jazzy"),
        (channel("/two words"), schema(), "'/two words' is not a topic name of ROS 2"),
    ],
)
def test_what_cannot_be_played_is_refused_with_a_reason(topic: Channel, of_type: Schema | None, why: str) -> None:
    assert recorded_topic(topic, of_type).refusal.startswith(why)


def test_types_that_are_not_common_are_left_to_the_installation() -> None:
    assert recorded_topic(channel(), schema("own_msgs/msg/Thing", "float64 x\n")).refusal == ""
    assert recorded_topic(channel(), schema("std_msgs/msg/String", "", "")).refusal == ""


@pytest.mark.parametrize(
    ("offered", "best_effort", "latched"),
    [
        ("- reliability: reliable\n  durability: volatile\n", False, False),
        ("- reliability: best_effort\n  durability: transient_local\n", True, True),
        ("- reliability: 2\n  durability: 1\n", True, True),
        ("- reliability: 2\n  durability: 2\n- reliability: 1\n  durability: 2\n", False, False),
        ("no yaml: [", False, False),
    ],
)
def test_the_offered_quality_of_service_is_read(offered: str, best_effort: bool, latched: bool) -> None:
    topic = recorded_topic(channel(qos=offered), schema())
    assert (topic.best_effort, topic.latched) == (best_effort, latched)


def test_messages_add_up() -> None:
    topic = recorded_topic(channel(), schema()).with_messages(2, 100).with_messages(3, 40)
    assert (topic.count, topic.largest) == (5, 100)


@pytest.mark.parametrize("name", ["/a", "/a/b_2"])
def test_names_that_are_allowed(name: str) -> None:
    assert name_problem(name) == ""
    assert absolute_name(name[1:]) == name


@pytest.mark.parametrize("name", ["/", "/2a", "/a__b", "/a-b", "/a//b"])
def test_names_that_are_not(name: str) -> None:
    assert "is not a topic name of ROS 2" in name_problem(name)
