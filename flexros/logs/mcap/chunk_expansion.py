"""Decompression of MCAP chunks; every claimed size is checked before memory is allocated."""

from __future__ import annotations

import struct
import zlib

import lz4.frame
import zstandard

from flexros.input_limits import LARGEST_CHUNK

_CHUNK_HEAD = struct.Struct("<QQQII")


class DamagedChunkError(Exception):
    """A chunk cannot be read; the scan reports the reason as a warning."""


class ExpansionLimitError(DamagedChunkError):
    """A chunk is larger than the remaining expansion limit of its file."""


def expand_chunk(record: memoryview, room: int = LARGEST_CHUNK) -> bytes:
    """Decompress a Chunk record and check it.

    Args:
        record: The record after opcode and length.
        room: Remaining expansion limit of the file [byte].

    Returns:
        The records in the chunk.

    Raises:
        DamagedChunkError: Sizes, compression or checksum are wrong.
        ExpansionLimitError: It is larger than `room`.
    """
    if len(record) < _CHUNK_HEAD.size:
        raise DamagedChunkError(f"it has only {len(record)} bytes")
    _, _, size, crc, name_length = _CHUNK_HEAD.unpack_from(record)
    start = _CHUNK_HEAD.size + name_length + 8
    if start > len(record):
        raise DamagedChunkError("its head is truncated")
    compression = bytes(record[_CHUNK_HEAD.size : start - 8]).decode(errors="replace")
    (length,) = struct.unpack_from("<Q", record, start - 8)
    if start + length > len(record):
        raise DamagedChunkError(f"it claims {length} bytes of data and has {len(record) - start}")
    if size > LARGEST_CHUNK:
        raise DamagedChunkError(f"it claims {size} bytes of messages, allowed is {LARGEST_CHUNK}")
    if size > room:
        raise ExpansionLimitError(f"it claims {size} bytes of messages, the limit of the file leaves {room}")
    data = _expand(compression, bytes(record[start : start + length]), size)
    if len(data) != size:
        raise DamagedChunkError(f"it claims {size} bytes of messages and holds {len(data)}")
    if crc and zlib.crc32(data) != crc:
        raise DamagedChunkError("its checksum (CRC) is wrong")
    return data


def _expand(compression: str, data: bytes, size: int) -> bytes:
    try:
        if compression == "zstd":
            if size == 0:
                return b""
            claimed = zstandard.frame_content_size(data)
            if claimed > size:
                raise DamagedChunkError(f"its zstd frame claims {claimed} bytes, the chunk {size}")
            return zstandard.ZstdDecompressor().decompress(data, max_output_size=size)
        if compression == "lz4":
            return lz4.frame.LZ4FrameDecompressor().decompress(data, max_length=size + 1)  # type: ignore[no-any-return]
    except (zstandard.ZstdError, RuntimeError, EOFError) as error:
        raise DamagedChunkError(f"{compression} reports '{error}'") from error
    if compression:
        raise DamagedChunkError(f"its compression '{compression}' is unknown; allowed are zstd, lz4 and none")
    return data
