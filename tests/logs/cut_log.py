"""A log truncated at any byte: messages that a reader must return, and those it returns."""

from __future__ import annotations

import os
import struct
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from mcap.opcode import Opcode
from mcap.writer import Writer

from flexros.logs.mcap.file_reader import McapFileReader
from flexros.logs.mcap.file_writer import MAGIC
from flexros.logs.message_block import MESSAGE_HEADER
from flexros.logs.messages.bulk_decode import payloads_of

_HEAD = struct.Struct("<BQ")


@dataclass(frozen=True)
class Recovery:
    """Content read from a log that was cut at many positions.

    Attributes:
        n_cuts: Number of cuts.
        n_expected: Messages of complete chunks, over all cuts.
        n_read: Those of them that were read with every bit.
        n_wrong: Messages that were read but are not among them.
    """

    n_cuts: int
    n_expected: int
    n_read: int
    n_wrong: int

    @property
    def share(self) -> float:
        """Messages that came back [1]."""
        return self.n_read / self.n_expected


def in_small_chunks(source: Path, target: Path, chunk_size: int) -> None:
    """Write the messages of a log again, in chunks of so many bytes.

    Args:
        source: An .mcap file.
        target: The file to write.
        chunk_size: Size of a chunk before compression [byte].
    """
    reader = McapFileReader(source)
    with target.open("wb") as stream:
        writer = Writer(stream, chunk_size=chunk_size)
        writer.start(profile="ros2")
        numbers: dict[int, int] = {}
        for block in reader.blocks():
            for number, channel in reader.channels.items():
                if number not in numbers:
                    schema = reader.schemas[channel.schema_id]
                    registered = writer.register_schema(schema.name, schema.encoding, schema.data)
                    numbers[number] = writer.register_channel(channel.topic, channel.message_encoding, registered)
            rows = np.arange(len(block.headers))
            for header, payload in zip(block.headers, payloads_of(block, rows), strict=True):
                time, number = int(header["log_time"]), numbers[int(header["channel"])]
                writer.add_message(number, time, payload, time, int(header["sequence"]))
        writer.finish()


def chunk_edges(content: bytes) -> list[tuple[int, int]]:
    """Begin and end of each Chunk record of a file [byte]."""
    edges, position = [], len(MAGIC)
    while position + _HEAD.size <= len(content):
        opcode, length = _HEAD.unpack_from(content, position)
        end = position + _HEAD.size + length
        if opcode == Opcode.CHUNK:
            edges.append((position, end))
        position = end
    return edges


def cuts_of(content: bytes, n_random: int, seed: int = 1) -> list[int]:
    """Bytes to cut at: around begin and end of every chunk and of the file, and at random ones, longest first."""
    edges = [edge for both in (*chunk_edges(content), (len(MAGIC), len(content))) for edge in both]
    near = {edge + d for edge in edges for d in range(-9, 10)}
    anywhere = np.random.default_rng(seed).integers(len(MAGIC), len(content), n_random).tolist()
    return sorted({cut for cut in (*near, *anywhere) if len(MAGIC) <= cut <= len(content)}, reverse=True)


def _messages(path: Path) -> list[tuple[bytes, bytes]]:
    """Headers of the messages of each chunk with the bytes in which they lie, chunk by chunk."""
    return [(block.headers.tobytes(), bytes(block.data)) for block in McapFileReader(path).blocks()]


def recovery(path: Path, cuts: list[int]) -> Recovery:
    """Cut a file at one place after the other and read what is left.

    Args:
        path: An .mcap file whose messages all lie in chunks; it is cut short.
        cuts: Bytes to cut at, longest first.

    Returns:
        What came back.
    """
    content = path.read_bytes()
    ends = [end for _, end in chunk_edges(content)]
    whole = _messages(path)
    assert len(whole) == len(ends)
    size = MESSAGE_HEADER.itemsize
    n_expected = n_read = n_wrong = 0
    for cut in cuts:
        os.truncate(path, cut)
        expected = whole[: sum(end <= cut for end in ends)]
        read = _messages(path)
        equal = [a == b for a, b in zip(expected, read, strict=False)]
        n_expected += sum(len(headers) for headers, _ in expected) // size
        n_read += sum(len(headers) for (headers, _), same in zip(expected, equal, strict=False) if same) // size
        n_wrong += sum(len(headers) for headers, _ in read[len(expected) :]) // size
    return Recovery(len(cuts), n_expected, n_read, n_wrong)
