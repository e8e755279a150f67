"""diagnostic_msgs/msg/DiagnosticArray: what nodes say of themselves, read from bytes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from flexros.logs.messages.cdr_cursor import CdrCursor, MessageError

TYPE = "diagnostic_msgs/msg/DiagnosticArray"


class DiagnosticStatus(NamedTuple):
    """State of one node.

    Attributes:
        level: 0 ok, 1 warning, 2 error, 3 stale.
        name: Name of the node, with its namespace.
        message: State in words.
        values: Values as text by key; the last where a key comes twice.
    """

    level: int
    name: str
    message: str
    values: dict[str, str]

    def numbers(self) -> dict[str, float]:
        """Give the values that are finite numbers, by key."""
        found = {}
        for key, text in self.values.items():
            try:
                value = float(text)
            except ValueError:
                continue  # a value may be any text
            if np.isfinite(value):
                found[key] = value
        return found


def read_diagnostic_array(payload: bytes) -> tuple[DiagnosticStatus, ...]:
    """Read a message from any sender.

    Args:
        payload: Serialised message.

    Returns:
        The states in it.

    Raises:
        MessageError: The bytes are not a DiagnosticArray.
    """
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
    """Read the length of a sequence whose entries begin with at least a byte."""
    count = cursor.uint32(what)
    if count > len(cursor.payload) - cursor.position:
        raise MessageError(f"a message of {len(cursor.payload)} bytes claims {count} entries of {what}")
    return count
