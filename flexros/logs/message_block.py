"""Serialised messages of a log in blocks, with headers as in MCAP (MCAP specification, record Message)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flexros.arrays import IntArray

MESSAGE_OPCODE = 0x05
MESSAGE_HEADER = np.dtype(
    [
        ("opcode", "u1"),
        ("length", "<u8"),
        ("channel", "<u2"),
        ("sequence", "<u4"),
        ("log_time", "<u8"),
        ("publish_time", "<u8"),
    ]
)
"""A Message record up to its payload, 31 bytes; `length` counts from its own end."""

LENGTH_FIELD_END = 9
"""Offset of the end of opcode and length [byte]; the length of a record counts from there."""


@dataclass(frozen=True, eq=False)
class MessageBlock:
    """Messages in the order of the file.

    Attributes:
        data: Bytes that contain the messages.
        headers: Their Message records without payload, type MESSAGE_HEADER, shape (n,).
        offsets: Offset of each payload in `data`, shape (n,).
    """

    data: bytes | memoryview
    headers: NDArray[np.void]
    offsets: NDArray[np.int64]


def slices(data: bytes | memoryview, begins: IntArray, length: int) -> NDArray[np.uint8]:
    """Copy slices of equal length out of bytes.

    Args:
        data: The bytes.
        begins: First byte of each slice; all slices lie within `data`, shape (n,).
        length: Bytes of a slice, at least one.

    Returns:
        Shape (n, length).
    """
    if not len(begins):
        return np.zeros((0, length), np.uint8)
    every: NDArray[np.void] = np.ndarray(len(data) - length + 1, dtype=f"V{length}", buffer=data, strides=1)
    return every[begins].view(np.uint8).reshape(len(begins), length)
