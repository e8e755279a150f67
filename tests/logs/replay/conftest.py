"""Logs of other recorders that the tests of the replay play."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import pytest
from mcap.writer import Writer
from rosbags.typesys import Stores, get_typestore

STORE = get_typestore(Stores.ROS2_JAZZY)
STRING = "std_msgs/msg/String"

Told = tuple[str, int, str]
"""Topic, log time [ns] and text of a message."""


def string_message(text: str) -> bytes:
    """Serialise a std_msgs/String."""
    return bytes(STORE.serialize_cdr(STORE.types[STRING](text), STRING))


def definition(type_name: str) -> bytes:
    """Give the schema text of a type."""
    text, _ = STORE.generate_msgdef(type_name, ros_version=2)
    return text.encode()


def write_strings(path: Path, messages: Iterable[Told], *, finish: bool = True, qos: str = "", **options: Any) -> Path:
    """Write a lone .mcap file of texts, as any recorder might."""
    with path.open("wb") as stream:
        writer = Writer(stream, **options)
        writer.start(profile="ros2")
        schema = writer.register_schema(STRING, "ros2msg", definition(STRING))
        channels: dict[str, int] = {}
        for k, (topic, time, text) in enumerate(messages):
            if topic not in channels:
                metadata = {"offered_qos_profiles": qos} if qos else {}
                channels[topic] = writer.register_channel(topic, "cdr", schema, metadata)
            writer.add_message(channels[topic], time, string_message(text), time, k)
        if finish:
            writer.finish()
    return path


@pytest.fixture(name="write_strings")
def write_strings_fixture() -> Callable[..., Path]:
    """Give the writer of texts."""
    return write_strings


@pytest.fixture(name="string_message")
def string_message_fixture() -> Callable[[str], bytes]:
    """Give the serialisation of a text."""
    return string_message
