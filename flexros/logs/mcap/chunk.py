"""Assembly of an MCAP chunk from many messages at once (MCAP specification, records Message and Message Index)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.logs.message_block import LENGTH_FIELD_END, MESSAGE_HEADER, MESSAGE_OPCODE

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from flexros.arrays import IntArray

INDEX_ENTRY = np.dtype([("log_time", "<u8"), ("offset", "<u8")])


@dataclass(frozen=True, eq=False)
class Chunk:
    """Messages of a chunk, before compression.

    Attributes:
        records: Message records one after the other.
        index: Log time and offset of each message, sorted by time, type INDEX_ENTRY, by channel.
        start_time: Earliest log time [ns].
        end_time: Latest log time [ns].
    """

    records: bytes
    index: Mapping[int, NDArray[np.void]]
    start_time: int
    end_time: int


def assemble_chunk(
    channel: IntArray,
    log_time: IntArray,
    publish_time: IntArray,
    payloads: Sequence[bytes],
    sequence_start: Mapping[int, int],
) -> Chunk:
    """Assemble messages into a chunk.

    Args:
        channel: Channel of each message, shape (n,), n > 0.
        log_time: Log times [ns], shape (n,).
        publish_time: Publish times [ns], shape (n,).
        payloads: Serialised messages, length n.
        sequence_start: Number of earlier messages of each channel; 0 if absent.
    """
    n = len(payloads)
    lengths = np.fromiter(map(len, payloads), np.int64, n)
    headers = np.empty(n, MESSAGE_HEADER)
    headers["opcode"] = MESSAGE_OPCODE
    headers["length"] = lengths + (MESSAGE_HEADER.itemsize - LENGTH_FIELD_END)
    headers["channel"] = channel
    headers["log_time"] = log_time
    headers["publish_time"] = publish_time
    offsets = np.zeros(n, np.int64)
    np.cumsum(lengths[:-1] + MESSAGE_HEADER.itemsize, out=offsets[1:])
    index = {}
    for number in np.unique(channel).tolist():
        rows = np.flatnonzero(channel == number)
        headers["sequence"][rows] = sequence_start.get(number, 0) + np.arange(len(rows))
        entries = np.empty(len(rows), INDEX_ENTRY)
        entries["log_time"], entries["offset"] = log_time[rows], offsets[rows]
        index[number] = entries[np.argsort(log_time[rows], kind="stable")]
    parts: list[bytes] = [b""] * (2 * n)
    parts[0::2] = headers.view(f"V{MESSAGE_HEADER.itemsize}").tolist()
    parts[1::2] = payloads
    return Chunk(b"".join(parts), index, int(log_time.min()), int(log_time.max()))
