"""Reading an MCAP file from the front: every message of every complete chunk, with or without a summary.

The summary and the indexes are not used, so a file that was cut off is read like a whole one.
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
from flexros.logs.chunk import LENGTH_FIELD_END, MESSAGE_HEADER, MESSAGE_OPCODE
from flexros.logs.chunk_expansion import DamagedChunkError, expand_chunk
from flexros.logs.mcap_file import MAGIC

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from numpy.typing import NDArray

_RECORD_HEAD = struct.Struct("<BQ")


@dataclass(frozen=True, eq=False)
class MessageBlock:
    """Messages in the order of the file.

    Attributes:
        data: Bytes in which the messages lie.
        headers: Their Message records without payload, type MESSAGE_HEADER, shape (n,).
        offsets: Where each payload begins in `data`, shape (n,).
    """

    data: bytes | memoryview
    headers: NDArray[np.void]
    offsets: NDArray[np.int64]


@dataclass
class McapScan:
    """One pass through a file: iterate over `blocks`; schemas, channels and warnings fill on the way.

    Attributes:
        path: The file.
        schemas: Schema records by number.
        channels: Channel records by number.
        warnings: Damage that was found, one sentence each.
    """

    path: Path
    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    warnings: list[str] = field(default_factory=list)

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
        yield from self._records(memoryview(content), len(MAGIC), "")

    def _records(self, data: memoryview, position: int, inside: str) -> Iterator[MessageBlock]:
        loose: list[int] = []
        n_chunks = 0
        while position < len(data):
            start = position + _RECORD_HEAD.size
            opcode, length = _RECORD_HEAD.unpack_from(data, position) if start <= len(data) else (0, len(data))
            if start + length > len(data):
                self.warnings.append(
                    f"{self.path} is cut off {inside}at byte {position} of {len(data)}: everything before was read"
                )
                break
            if opcode == MESSAGE_OPCODE:
                loose.append(position)
            elif opcode == Opcode.CHUNK and not inside:
                records = self._chunk(
                    data[start : start + length], f"chunk {n_chunks} at byte {position} of {self.path}"
                )
                n_chunks += 1
                yield from self._records(records, 0, f"inside chunk {n_chunks - 1} ")
            elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                self._definition(opcode, bytes(data[start : start + length]), position)
            elif opcode in (Opcode.DATA_END, Opcode.FOOTER):
                break
            position = start + length
        else:
            if not inside:
                self.warnings.append(
                    f"{self.path} has no end mark: its recorder was killed; every complete chunk was read"
                )
        if loose:
            yield self._block(data, np.array(loose))

    def _definition(self, opcode: int, record: bytes, position: int) -> None:
        try:
            stream = ReadDataStream(BytesIO(record))
            if opcode == Opcode.SCHEMA:
                schema = Schema.read(stream)
                self.schemas[schema.id] = schema
            else:
                channel = Channel.read(stream)
                self.channels[channel.id] = channel
        except (struct.error, ValueError, EndOfFile) as error:
            self.warnings.append(f"{self.path}: the record at byte {position} is damaged and was left out: {error}")

    def _block(self, data: memoryview, positions: NDArray[np.int64]) -> MessageBlock:
        size = MESSAGE_HEADER.itemsize
        fitting = positions[positions + size <= len(data)]
        heads = b"".join([data[p : p + size] for p in fitting.tolist()])
        headers: NDArray[np.void] = np.frombuffer(heads, MESSAGE_HEADER)
        whole = headers["length"] >= size - LENGTH_FIELD_END
        if (n_short := len(positions) - np.count_nonzero(whole)) > 0:
            self.warnings.append(f"{self.path}: {n_short} message records are too short and were left out")
        return MessageBlock(data, headers[whole], fitting[whole] + size)

    def _chunk(self, record: memoryview, where: str) -> memoryview:
        """Decompress a chunk; an empty view and a warning if it is damaged."""
        try:
            return memoryview(expand_chunk(record))
        except DamagedChunkError as damage:
            self.warnings.append(f"{where} is damaged and was left out: {damage}")
            return memoryview(b"")
