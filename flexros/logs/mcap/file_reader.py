"""Sequential reading of an MCAP file: every message of every complete chunk, with or without a summary.

The summary and the indexes are not used, so a truncated file is read like a complete one.
"""

from __future__ import annotations

import mmap
import struct
from dataclasses import dataclass, field
from io import BytesIO
from typing import TYPE_CHECKING

import numpy as np
from mcap.data_stream import ReadDataStream
from mcap.exceptions import EndOfFile
from mcap.opcode import Opcode
from mcap.records import Channel, Schema

from flexros.errors import InputError
from flexros.input_limits import EXPANSION, LARGEST_DEFINITIONS, MOST_DEFINITIONS, MOST_WARNINGS, room_of
from flexros.logs.mcap.chunk_expansion import DamagedChunkError, ExpansionLimitError, expand_chunk
from flexros.logs.mcap.file_writer import MAGIC
from flexros.logs.message_block import LENGTH_FIELD_END, MESSAGE_HEADER, MESSAGE_OPCODE, MessageBlock, slices

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from numpy.typing import NDArray


_RECORD_HEAD = struct.Struct("<BQ")
_SHORTEST_MESSAGE = MESSAGE_HEADER.itemsize - LENGTH_FIELD_END

_RELEASED = 1 << 24
"""Bytes of a file whose memory is released together, chosen."""

_MOST_LOOSE = 100_000
"""Largest number of messages outside of chunks in one block [1], chosen."""


@dataclass
class McapFileReader:
    """One pass through a file: iterate over `blocks`; schemas, channels and warnings are filled during it.

    Attributes:
        path: The file.
        schemas: Schema records by number.
        channels: Channel records by number.
        warnings: Damage in the file, one sentence each.
    """

    path: Path
    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    warnings: list[str] = field(default_factory=list)
    _room: int = field(default=0, init=False)
    _definitions: set[bytes] = field(default_factory=set, init=False)
    _definition_room: int = field(default=LARGEST_DEFINITIONS, init=False)
    _n_unreported: int = field(default=0, init=False)
    _content: mmap.mmap = field(init=False, repr=False)
    _released: int = field(default=0, init=False)

    def blocks(self) -> Iterator[MessageBlock]:
        """Read the file.

        Yields:
            The messages of each chunk, and those outside of chunks.

        Raises:
            InputError: The file cannot be read or is not MCAP.
        """
        try:
            with self.path.open("rb") as file:
                content = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
        except OSError as error:
            raise InputError(f"cannot read {self.path}: {error.strerror}; give a readable log") from error
        except ValueError as error:
            raise InputError(f"{self.path} is empty; give a rosbag2 folder or an .mcap file with messages") from error
        if content[: len(MAGIC)] != MAGIC:
            raise InputError(
                f"{self.path} is not an MCAP file (it begins with {content[:8]!r}); give a rosbag2 folder or .mcap"
            )
        self._room = room_of(len(content))
        self._content, self._released = content, 0
        yield from self._file_records(memoryview(content), len(MAGIC))
        if self._n_unreported:
            self.warnings.append(f"{self.path} has damage at {self._n_unreported} further positions")

    def _warn(self, text: str) -> None:
        """Report damage; beyond a limit it is only counted."""
        if len(self.warnings) < MOST_WARNINGS:
            self.warnings.append(text)
        else:
            self._n_unreported += 1

    def _file_records(self, data: memoryview, position: int) -> Iterator[MessageBlock]:
        loose: list[int] = []
        n_chunks, n_beyond = 0, 0
        while position < len(data):
            start = position + _RECORD_HEAD.size
            opcode, length = _RECORD_HEAD.unpack_from(data, position) if start <= len(data) else (0, len(data))
            if start + length > len(data):
                self.warnings.append(
                    f"{self.path} is truncated at byte {position} of {len(data)}: everything before was read"
                )
                break
            if opcode == MESSAGE_OPCODE:
                loose.append(position)
                if len(loose) == _MOST_LOOSE:
                    yield self._block(data, np.array(loose))
                    loose = []
            elif opcode == Opcode.CHUNK:
                where = f"chunk {n_chunks} at byte {position} of {self.path}"
                n_chunks += 1
                try:
                    yield from self._chunk(data[start : start + length], where)
                except ExpansionLimitError:
                    n_beyond += 1
            elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                self._definition(opcode, bytes(data[start : start + length]), position)
            elif opcode in (Opcode.DATA_END, Opcode.FOOTER):
                break
            position = start + length
            if not loose:
                self._release(position)
        else:
            self.warnings.append(f"{self.path} has no end record (recorder killed); every complete chunk was read")
        if n_beyond:
            self.warnings.append(
                f"{self.path} has {len(data)} bytes and its chunks expand to more than {EXPANSION} times as much, the "
                f"limit: {n_beyond} of {n_chunks} chunks were left out"
            )
        if loose:
            yield self._block(data, np.array(loose))

    def _release(self, position: int) -> None:
        """Release the memory of the file before a position: pages that were read count as memory of the process."""
        end = position - position % mmap.PAGESIZE
        if end - self._released >= _RELEASED and hasattr(self._content, "madvise"):
            self._content.madvise(mmap.MADV_DONTNEED, self._released, end - self._released)
            self._released = end

    def _chunk(self, record: memoryview, where: str) -> Iterator[MessageBlock]:
        """Read the messages of a chunk; none and a warning if it is damaged."""
        try:
            data = memoryview(expand_chunk(record, self._room))
        except ExpansionLimitError:
            raise
        except DamagedChunkError as damage:
            self._warn(f"{where} is damaged and was left out: {damage}")
            return
        self._room -= max(0, len(data) - len(record))
        positions: list[int] = []
        size, head, unpack = len(data), _RECORD_HEAD.size, _RECORD_HEAD.unpack_from
        position = 0
        while position < size:
            start = position + head
            opcode, length = unpack(data, position) if start <= size else (0, size)
            if start + length > size:
                self._warn(f"{where} is truncated inside, at its byte {position} of {size}: everything before was read")
                break
            if opcode == MESSAGE_OPCODE and length >= _SHORTEST_MESSAGE:
                positions.append(position)
            elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                self._definition(opcode, bytes(data[start : start + length]), position)
            else:
                self._warn(
                    f"{where} contains a record that is not allowed in a chunk (opcode {opcode}, {length} bytes); "
                    "the rest of the chunk was left out"
                )
                break
            position = start + length
        if positions:
            yield self._block(data, np.array(positions))

    def _definition(self, opcode: int, record: bytes, position: int) -> None:
        key = bytes((opcode,)) + record
        if key in self._definitions or self._definition_room < 0:
            return
        self._definition_room -= len(record)
        if len(self._definitions) == MOST_DEFINITIONS or self._definition_room < 0:
            self._definition_room = -1
            self.warnings.append(
                f"{self.path} defines more than {MOST_DEFINITIONS} types and topics, or more than "
                f"{LARGEST_DEFINITIONS} bytes of them: the rest is unread"
            )
            return
        self._definitions.add(key)
        try:
            stream = ReadDataStream(BytesIO(record))
            if opcode == Opcode.SCHEMA:
                schema = Schema.read(stream)
                self.schemas[schema.id] = schema
            else:
                channel = Channel.read(stream)
                self.channels[channel.id] = channel
        except (struct.error, ValueError, EndOfFile) as error:
            self._warn(f"{self.path}: the record at byte {position} is damaged and was left out: {error}")

    def _block(self, data: memoryview, positions: NDArray[np.int64]) -> MessageBlock:
        size = MESSAGE_HEADER.itemsize
        fitting = positions[positions + size <= len(data)]
        headers: NDArray[np.void] = slices(data, fitting, size).view(MESSAGE_HEADER)[:, 0]
        whole = headers["length"] >= size - LENGTH_FIELD_END
        if (n_short := len(positions) - np.count_nonzero(whole)) > 0:
            self._warn(f"{self.path}: {n_short} message records are too short and were left out")
        return MessageBlock(data, headers[whole], fitting[whole] + size)
