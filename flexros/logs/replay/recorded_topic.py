"""A topic in a file, and the check whether its messages can be played to nodes of ROS 2 Jazzy."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from flexros.logs.messages.foreign_definition import is_common
from flexros.logs.messages.schemas import is_common_type

if TYPE_CHECKING:
    from mcap.records import Channel, Schema

_TYPE = re.compile(r"([a-z][a-z0-9_]*)/(?:(msg|srv|action)/)?([A-Za-z][A-Za-z0-9_]*)")
_NAME = re.compile(r"(/[A-Za-z_][A-Za-z0-9_]*)+")
_BEST_EFFORT = ("best_effort", "2")
_LATCHED = re.compile(r"durability:\s*(?:transient_local|1)\b")


@dataclass(frozen=True)
class RecordedTopic:
    """A topic of a log.

    Attributes:
        name: Absolute name.
        type: Message type, e.g. "sensor_msgs/msg/JointState".
        best_effort: Whether all publishers offered best effort only.
        latched: Whether a publisher kept its last messages for late subscribers (transient local).
        count: Number of messages.
        largest: Size of the largest message [byte].
        refusal: Why it cannot be played; empty if it can.
    """

    name: str
    type: str
    best_effort: bool = False
    latched: bool = False
    count: int = 0
    largest: int = 0
    refusal: str = ""

    def with_messages(self, count: int, largest: int) -> RecordedTopic:
        """Return the topic with `count` further messages, the largest of size `largest` [byte]."""
        return replace(self, count=self.count + count, largest=max(self.largest, largest))


def absolute_name(name: str) -> str:
    """Return a topic name with a leading slash."""
    return "/" + name.strip("/")


def recorded_topic(channel: Channel, schema: Schema | None) -> RecordedTopic:
    """Read the description of a topic in a file.

    Args:
        channel: Its Channel record.
        schema: The Schema record that the channel names, None if the file has none.

    Returns:
        The topic, with no messages counted.
    """
    name = absolute_name(channel.topic)
    type_name = "" if schema is None else type_in_full(schema.name)
    offered = str(channel.metadata.get("offered_qos_profiles", ""))
    words = re.findall(r"reliability:\s*(\w+)", offered)
    return RecordedTopic(
        name=name,
        type=type_name or ("unknown type" if schema is None else schema.name),
        best_effort=bool(words) and all(word in _BEST_EFFORT for word in words),
        latched=bool(_LATCHED.search(offered)),
        refusal=_refusal(name, channel, schema, type_name),
    )


def type_in_full(name: str) -> str:
    """Return a type in three parts, "package/msg/Name"; empty if it is not the name of a ROS type."""
    match = _TYPE.fullmatch(name)
    return "" if match is None else f"{match[1]}/{match[2] or 'msg'}/{match[3]}"


def name_problem(name: str) -> str:
    """Return why ROS 2 does not allow an absolute topic name; empty if it does."""
    if _NAME.fullmatch(name) and "__" not in name:
        return ""
    return f"'{name}' is not a topic name of ROS 2 (letters, digits and single underscores between slashes)"


def _refusal(name: str, channel: Channel, schema: Schema | None, type_name: str) -> str:
    if schema is None:
        return "the file does not define its type"
    if not type_name:
        return f"its type '{schema.name}' is not a ROS 2 type"
    if channel.message_encoding != "cdr":
        return f"it is encoded as '{channel.message_encoding}', nodes of ROS 2 accept cdr"
    if schema.encoding == "ros2msg" and schema.data.strip() and is_common_type(type_name):
        schema = replace(schema, name=type_name)
        if not is_common(schema):
            return f"its definition of {type_name} is not that of ROS 2 Jazzy"
    return name_problem(name)
