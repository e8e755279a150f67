"""Writer of an MCAP file, chunk by chunk; the file is readable up to its last complete chunk at any time."""

from __future__ import annotations

import struct
import zlib
from collections import Counter
from typing import TYPE_CHECKING

import zstandard
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Channel,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from pathlib import Path

    from flexros.logs.mcap.chunk import Chunk

MAGIC = b"\x89MCAP0\r\n"
LIBRARY = "flexros"

_COMPRESSION_LEVEL = 1  # chosen: fastest level of the standard range; numbers compress little at any level


class McapFileWriter:
    """Writes an MCAP file of the profile ros2.

    After every method the file ends at a complete record; a failed write is truncated.

    Args:
        path: File to create; it must not exist.
    """

    def __init__(self, path: Path) -> None:
        self._file = path.open("xb", buffering=0)
        self._compressor = zstandard.ZstdCompressor(level=_COMPRESSION_LEVEL)
        self._end = 0
        self._schemas: list[Schema] = []
        self._channels: list[Channel] = []
        self._chunks: list[ChunkIndex] = []
        self._counts: list[Counter[int]] = []
        self._counted: Counter[int] = Counter()
        self._last_chunk = b""
        self._finished = False
        try:
            self._append(MAGIC + _record(Header("ros2", LIBRARY)))
        except OSError:
            self._file.close()
            raise

    @property
    def counts(self) -> Mapping[int, int]:
        """Messages in the file, by channel."""
        return self._counted

    @property
    def time_range(self) -> tuple[int, int]:
        """Earliest and latest log time [ns], zeros when empty."""
        if not self._chunks:
            return 0, 0
        return min(c.message_start_time for c in self._chunks), max(c.message_end_time for c in self._chunks)

    def _append(self, data: bytes) -> None:
        view = memoryview(data)
        try:
            while view:
                view = view[self._file.write(view) :]
        except OSError:
            self._truncate(self._end)
            raise
        self._end += len(data)

    def _truncate(self, end: int) -> None:
        self._file.truncate(end)
        self._file.seek(end)
        self._end = end

    def add_channel(self, topic: str, type_name: str, schema_text: str, metadata: Mapping[str, str]) -> int:
        """Write schema and channel of a topic; return the number of the channel, from 1."""
        known = [schema for schema in self._schemas if schema.name == type_name]
        schema = (
            known[0]
            if known
            else Schema(id=len(self._schemas) + 1, name=type_name, encoding="ros2msg", data=schema_text.encode())
        )
        channel = Channel(
            id=len(self._channels) + 1,
            topic=topic,
            message_encoding="cdr",
            schema_id=schema.id,
            metadata=dict(metadata),
        )
        self._append((b"" if known else _record(schema)) + _record(channel))
        if not known:
            self._schemas.append(schema)
        self._channels.append(channel)
        return len(self._channels)

    def append(self, chunk: Chunk) -> None:
        """Compress a chunk and write it with its message indexes.

        Raises:
            OSError: The chunk does not fit on the disk; the file is unchanged.
        """
        compressed = self._compressor.compress(chunk.records)
        head = struct.pack("<QQQI", chunk.start_time, chunk.end_time, len(chunk.records), zlib.crc32(chunk.records))
        body = b"".join((head, struct.pack("<I4sQ", 4, b"zstd", len(compressed)), compressed))
        parts = [struct.pack("<BQ", Opcode.CHUNK, len(body)), body]
        length = index_start = 9 + len(body)
        offsets = {}
        for number, entries in chunk.index.items():
            offsets[number] = self._end + length
            index = entries.tobytes()
            parts.append(struct.pack("<BQHI", Opcode.MESSAGE_INDEX, 6 + len(index), number, len(index)) + index)
            length += len(parts[-1])
        summary = ChunkIndex(
            chunk_start_offset=self._end,
            chunk_length=index_start,
            message_start_time=chunk.start_time,
            message_end_time=chunk.end_time,
            message_index_offsets=offsets,
            message_index_length=length - index_start,
            compression="zstd",
            compressed_size=len(compressed),
            uncompressed_size=len(chunk.records),
        )
        block = b"".join(parts)
        self._append(block)
        self._last_chunk = block
        self._chunks.append(summary)
        self._counts.append(Counter({number: len(entries) for number, entries in chunk.index.items()}))
        self._counted += self._counts[-1]

    def finish_in_less_space(self, metadata_name: str, metadata: Callable[[], Mapping[str, str]]) -> bool:
        """Replace the last chunk by the summary, on a full disk. `close` must follow.

        Args:
            metadata_name: As in `finish`.
            metadata: Returns the metadata for the counts without that chunk.

        Returns:
            Whether the summary fits; if not, the chunk is restored, and readers must scan the file.
        """
        if not self._chunks:
            return False
        chunk, counts, last = self._chunks.pop(), self._counts.pop(), self._last_chunk
        self._counted -= counts
        self._truncate(chunk.chunk_start_offset)
        try:
            self.finish(metadata_name, metadata())
        except OSError:
            self._append(last)
            self._chunks.append(chunk)
            self._counts.append(counts)
            self._counted += counts
            return False
        return True

    def finish(self, metadata_name: str, metadata: Mapping[str, str]) -> None:
        """Write a Metadata record, the summary and the footer, once. `close` must follow.

        Raises:
            OSError: They do not fit on the disk; the file is unchanged.
        """
        if self._finished:
            return
        end = self._end
        record = _record(Metadata(name=metadata_name, metadata=dict(metadata)))
        index = MetadataIndex(offset=end, length=len(record), name=metadata_name)
        head = record + _record(DataEnd(0))
        self._append(head + self._summary(end + len(head), index))
        self._finished = True

    def _summary(self, start: int, index: MetadataIndex) -> bytes:
        first, last = self.time_range
        statistics = Statistics(
            message_count=sum(self._counted.values()),
            schema_count=len(self._schemas),
            channel_count=len(self._channels),
            attachment_count=0,
            metadata_count=1,
            chunk_count=len(self._chunks),
            message_start_time=first,
            message_end_time=last,
            channel_message_counts=dict(self._counted),
        )
        groups = (
            (Opcode.SCHEMA, self._schemas),
            (Opcode.CHANNEL, self._channels),
            (Opcode.STATISTICS, [statistics]),
            (Opcode.CHUNK_INDEX, self._chunks),
            (Opcode.METADATA_INDEX, [index]),
        )
        data, offsets = bytearray(), bytearray()
        for opcode, records in groups:
            group = b"".join(_record(record) for record in records)
            if group:
                offsets += _record(SummaryOffset(opcode, start + len(data), len(group)))
            data += group
        offset_start = start + len(data)
        data += offsets
        crc = zlib.crc32(struct.pack("<BQQQ", Opcode.FOOTER, 20, start, offset_start), zlib.crc32(data))
        return bytes(data) + _record(Footer(start, offset_start, crc)) + MAGIC

    def close(self) -> None:
        """Close the file as it is."""
        self._file.close()


def _record(
    record: Header
    | Schema
    | Channel
    | Metadata
    | MetadataIndex
    | DataEnd
    | Statistics
    | ChunkIndex
    | SummaryOffset
    | Footer,
) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    data: bytes = builder.end()
    return data
