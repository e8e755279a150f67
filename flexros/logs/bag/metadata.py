"""metadata.yaml of a rosbag2 folder, version 9, as ROS 2 Jazzy writes it."""

from __future__ import annotations

import re
from dataclasses import dataclass
from io import StringIO
from typing import TYPE_CHECKING, Any

from ruamel.yaml import YAML

from flexros.atomic_file import write_whole
from flexros.logs.provenance_file import PROVENANCE_FILE

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from flexros.config.topics import QosProfile

METADATA_FILE = "metadata.yaml"
VERSION = 9
ROS_DISTRO = "jazzy"

_WORD = re.compile("[A-Za-z/][A-Za-z0-9_/.]*")
_WIDTH = 80
_NOT_TEXT = {"true", "false", "yes", "no", "on", "off", "y", "n", "null"}

_INFINITE = {"sec": 9223372036, "nsec": 854775807}


@dataclass(frozen=True)
class BagTopic:
    """A topic in the metadata of a bag.

    Attributes:
        name: Absolute topic name.
        type: Message type.
        qos: Profile that the publisher offered.
        type_hash: Hash of the type description.
        message_count: Number of messages in the bag.
    """

    name: str
    type: str
    qos: QosProfile
    type_hash: str
    message_count: int = 0


@dataclass(frozen=True)
class BagMetadata:
    """Content of metadata.yaml.

    Attributes:
        file_name: The MCAP file in the folder.
        topics: Its topics.
        start_ns: Earliest log time [ns].
        end_ns: Latest log time [ns].
    """

    file_name: str
    topics: tuple[BagTopic, ...]
    start_ns: int = 0
    end_ns: int = 0

    def content(self) -> dict[str, Any]:
        """Return the mapping below the key rosbag2_bagfile_information."""
        duration = {"nanoseconds": self.end_ns - self.start_ns}
        start = {"nanoseconds_since_epoch": self.start_ns}
        count = sum(topic.message_count for topic in self.topics)
        return {
            "version": VERSION,
            "storage_identifier": "mcap",
            "duration": duration,
            "starting_time": start,
            "message_count": count,
            "topics_with_message_count": [_topic_entry(topic) for topic in self.topics],
            "compression_format": "",
            "compression_mode": "",
            "relative_file_paths": [self.file_name],
            "files": [
                {"path": self.file_name, "starting_time": start, "duration": duration, "message_count": count},
            ],
            "custom_data": {"provenance": PROVENANCE_FILE},
            "ros_distro": ROS_DISTRO,
        }

    def write(self, folder: Path) -> None:
        """Write metadata.yaml."""
        write_whole(folder / METADATA_FILE, as_yaml({"rosbag2_bagfile_information": self.content()}))


def _topic_entry(topic: BagTopic) -> dict[str, Any]:
    return {
        "topic_metadata": {
            "name": topic.name,
            "type": topic.type,
            "serialization_format": "cdr",
            "offered_qos_profiles": [offered_qos(topic.qos)],
            "type_description_hash": topic.type_hash,
        },
        "message_count": topic.message_count,
    }


def offered_qos(profile: QosProfile) -> dict[str, Any]:
    """Return a profile in the form of rosbag2; deadline, lifespan and lease are infinite."""
    return {
        "history": profile.history,
        "depth": profile.depth,
        "reliability": profile.reliability,
        "durability": profile.durability,
        "deadline": dict(_INFINITE),
        "lifespan": dict(_INFINITE),
        "liveliness": "automatic",
        "liveliness_lease_duration": dict(_INFINITE),
        "avoid_ros_namespace_conventions": False,
    }


def as_yaml(content: dict[str, Any] | list[dict[str, Any]]) -> str:
    """Return YAML text in block style, keys in the given order, without aliases."""
    lines = list(_block(content))
    if None not in lines:
        return "".join(f"{line}\n" for line in lines)
    yaml = YAML(typ="safe", pure=True)
    yaml.default_flow_style = False
    yaml.sort_base_mapping_type_on_output = False  # type: ignore[assignment]
    yaml.representer.ignore_aliases = lambda data: True
    stream = StringIO()
    yaml.dump(content, stream)
    return stream.getvalue()


def _block(content: dict[str, Any] | list[Any], column: int = 0) -> Iterator[str | None]:
    """Write what needs no quotes as ruamel.yaml does, in a hundredth of its time; yield None for anything else."""
    for key, value in content.items() if isinstance(content, dict) else (("-", item) for item in content):
        if isinstance(value, dict | list) and value:
            if key == "-":
                first, *others = _block(value, column + 2)
                yield None if first is None else f"- {first}"
            else:
                yield f"{key}:"
                others = list(_block(value, column + 2 * isinstance(value, dict)))
            indent = "  " if key == "-" or isinstance(value, dict) else ""
            yield from (None if line is None else indent + line for line in others)
        elif (text := _plain(value)) is None:
            yield None
        elif key == "-":
            yield f"- {text}"
        elif column + len(key) + 2 + len(text) > _WIDTH:
            yield from (f"{key}: ", f"  {text}")
        else:
            yield f"{key}: {text}"


def _plain(value: object) -> str | None:
    """Return the text of a number, a flag or a word, None where quotes may be needed."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, str) and _WORD.fullmatch(value) and value.lower() not in _NOT_TEXT:
        return value
    return "''" if value == "" else None
