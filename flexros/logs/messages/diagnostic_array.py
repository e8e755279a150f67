"""diagnostic_msgs/msg/DiagnosticArray: state of nodes, read from bytes."""

from __future__ import annotations

from typing import ClassVar, NamedTuple, final

import numpy as np

from flexros.logs.cdr_cursor import CdrCursor, MessageError
from flexros.logs.messages.codec import AbstractCodec


class DiagnosticStatus(NamedTuple):
    """State of one node.

    Attributes:
        level: 0 ok, 1 warning, 2 error, 3 stale.
        name: Name of the node, with its namespace.
        message: State in words.
        values: Values as text by key; the last one of a repeated key.
    """

    level: int
    name: str
    message: str
    values: dict[str, str]

    def numbers(self) -> dict[str, float]:
        """Return the values that are finite numbers, by key."""
        numbers = {}
        for key, text in self.values.items():
            try:
                value = float(text)
            except ValueError:
                continue  # a value may be any text
            if np.isfinite(value):
                numbers[key] = value
        return numbers


@final
class DiagnosticArrayCodec(AbstractCodec[tuple[DiagnosticStatus, ...]]):
    """diagnostic_msgs/msg/DiagnosticArray: state of nodes, in words and values."""

    type: ClassVar[str] = "diagnostic_msgs/msg/DiagnosticArray"
    sampled: ClassVar[bool] = False

    def read(self, payload: bytes | memoryview) -> tuple[DiagnosticStatus, ...]:
        """Return the states in a message."""
        cursor = CdrCursor(payload)
        cursor.skip(8, "header.stamp")
        cursor.string("header.frame_id")
        return tuple(_status(cursor) for _ in range(_count(cursor, "status")))


def _status(cursor: CdrCursor) -> DiagnosticStatus:
    level = cursor.payload[cursor.skip(1, "status.level")]
    name, message = cursor.string("status.name"), cursor.string("status.message")
    cursor.string("status.hardware_id")
    pairs = [(cursor.string("key"), cursor.string("value")) for _ in range(_count(cursor, "status.values"))]
    return DiagnosticStatus(level, name, message, dict(pairs))


def _count(cursor: CdrCursor, what: str) -> int:
    """Read the length of a sequence whose entries have at least one byte."""
    count = cursor.uint32(what)
    if count > len(cursor.payload) - cursor.position:
        raise MessageError(f"a message of {len(cursor.payload)} bytes claims {count} entries of {what}")
    return count
