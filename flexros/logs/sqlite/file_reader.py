"""Sequential reading of a .db3 file of rosbag2, in blocks like those of an MCAP file."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

import numpy as np
from mcap.records import Channel, Schema

from flexros.errors import InputError
from flexros.input_limits import LARGEST_DEFINITION, MOST_DEFINITIONS
from flexros.logs.message_block import LENGTH_FIELD_END, MESSAGE_HEADER, MESSAGE_OPCODE, MessageBlock

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

SUFFIX = ".db3"
"""Suffix of the files of this storage."""

STORAGE = "sqlite3"
"""Name of this storage in the metadata of a bag."""

_BLOCK = 1 << 22
"""Bytes of payload from which a block ends, chosen."""

_LATEST = 2**63 - 1


@dataclass
class SqliteFileReader:
    """One pass through a file: iterate over `blocks`; schemas and channels are filled before the first of them.

    Up to ROS 2 Humble a file names the types of its topics and does not define them: then the definitions of the
    packages of ROS 2 count. Types of other packages have an empty definition.

    Attributes:
        path: The file.
        schemas: Schema records by number.
        channels: Channel records by number, one for each topic.
        warnings: Damage in the file, one sentence each.
    """

    path: Path
    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    warnings: list[str] = field(default_factory=list)

    def blocks(self) -> Iterator[MessageBlock]:
        """Read the file.

        Yields:
            Its messages, in the order in which they were recorded.

        Raises:
            InputError: The file cannot be read or is no bag.
        """
        try:
            with closing(self._connection()) as connection:
                numbers = self._topics(connection)
                yield from self._messages(connection, numbers)
        except sqlite3.Error as error:
            raise InputError(
                f"{self.path} cannot be read as a bag in SQLite storage ({error}); give a whole copy of it"
            ) from error

    def _connection(self) -> sqlite3.Connection:
        """Open the file without writing next to it; a log of changes beside it is read where there is one."""
        way = "mode=ro" if self.path.with_name(self.path.name + "-wal").is_file() else "immutable=1"
        return sqlite3.connect(f"file:{quote(str(self.path.resolve()))}?{way}", uri=True)

    def _topics(self, connection: sqlite3.Connection) -> dict[int, int]:
        """Fill schemas and channels; return the number of the channel of each topic."""
        query = "SELECT id, name, type, serialization_format FROM topics ORDER BY id"
        rows = connection.execute(query).fetchmany(MOST_DEFINITIONS + 1)
        if len(rows) > MOST_DEFINITIONS:
            self.warnings.append(f"{self.path} has more than {MOST_DEFINITIONS} topics: the rest is unread")
            rows = rows[:MOST_DEFINITIONS]
        defined, types, numbers = _definitions(connection), dict[str, int](), dict[int, int]()
        for channel, (topic, name, type_name, encoding) in enumerate(rows):
            number = types.setdefault(str(type_name), len(types) + 1)
            if number not in self.schemas:
                kind, text = defined.get(str(type_name)) or ("ros2msg", _common_definition(str(type_name)))
                self.schemas[number] = Schema(number, text.encode(), kind, str(type_name))
            self.channels[channel] = Channel(channel, str(name), str(encoding), {}, number)
            numbers[topic] = channel
        return numbers

    def _messages(self, connection: sqlite3.Connection, numbers: dict[int, int]) -> Iterator[MessageBlock]:
        query = "SELECT topic_id, CAST(timestamp AS INTEGER), CAST(data AS BLOB) FROM messages ORDER BY id"
        channels: list[int] = []
        times: list[int] = []
        payloads: list[bytes] = []
        size, n_unknown = 0, 0
        for topic, time, payload in self._rows(connection.execute(query)):
            if topic not in numbers or time is None or payload is None:
                n_unknown += 1
                continue
            channels.append(numbers[topic])
            times.append(min(max(time, 0), _LATEST))
            payloads.append(payload)
            size += len(payload)
            if size >= _BLOCK:
                yield _block(channels, times, payloads)
                channels, times, payloads, size = [], [], [], 0
        if payloads:
            yield _block(channels, times, payloads)
        if n_unknown:
            self.warnings.append(f"{self.path}: {n_unknown} messages belong to no topic, they were left out")

    def _rows(self, cursor: sqlite3.Cursor) -> Iterator[tuple[Any, ...]]:
        """Yield the rows up to damage."""
        try:
            yield from cursor
        except sqlite3.Error as error:
            self.warnings.append(f"{self.path} is damaged ({error}): everything before was read")


def _block(channels: list[int], times: list[int], payloads: list[bytes]) -> MessageBlock:
    lengths = np.fromiter(map(len, payloads), np.int64, len(payloads))
    headers = np.zeros(len(payloads), MESSAGE_HEADER)
    headers["opcode"] = MESSAGE_OPCODE
    headers["length"] = lengths + (MESSAGE_HEADER.itemsize - LENGTH_FIELD_END)
    headers["channel"] = channels
    headers["log_time"] = headers["publish_time"] = times
    return MessageBlock(b"".join(payloads), headers, np.concatenate([[0], np.cumsum(lengths[:-1])]).astype(np.int64))


def _definitions(connection: sqlite3.Connection) -> dict[str, tuple[str, str]]:
    """Return encoding and text of the definitions in the file by type; files up to ROS 2 Humble have none."""
    query = "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions"
    try:
        rows: list[tuple[Any, ...]] = connection.execute(query).fetchmany(MOST_DEFINITIONS)
    except sqlite3.OperationalError:  # no such table
        return {}
    return {str(name): (str(kind), str(text)) for name, kind, text in rows if 0 < len(str(text)) <= LARGEST_DEFINITION}


def _common_definition(type_name: str) -> str:
    """Return the definition of a type of the packages of ROS 2, empty for one of other packages."""
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    return store.generate_msgdef(type_name, ros_version=2)[0] if type_name in store.fielddefs else ""
