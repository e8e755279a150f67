from __future__ import annotations

import struct
import tracemalloc
import zlib

import lz4.frame
import pytest
import zstandard

from flexros.logs.mcap.chunk_expansion import DamagedChunkError, expand_chunk

DATA = bytes(range(256)) * 40
SIZE, CRC = len(DATA), zlib.crc32(DATA)


def record(compression, data, size=SIZE, crc=CRC, length=None):
    name = compression.encode()
    head = struct.pack("<QQQII", 0, 0, size, crc, len(name)) + name
    return memoryview(head + struct.pack("<Q", len(data) if length is None else length) + data)


COMPRESSED = {"": DATA, "zstd": zstandard.compress(DATA), "lz4": lz4.frame.compress(DATA)}


@pytest.mark.parametrize("compression", COMPRESSED)
def test_every_compression_is_read(compression):
    assert expand_chunk(record(compression, COMPRESSED[compression])) == DATA


def test_zstd_frame_without_its_size_is_read():
    data = zstandard.ZstdCompressor(write_content_size=False).compress(DATA)
    assert expand_chunk(record("zstd", data)) == DATA


def test_checksum_of_zero_is_not_checked():
    assert expand_chunk(record("", DATA, crc=0)) == DATA


@pytest.mark.parametrize("compression", COMPRESSED)
def test_wrong_checksum_is_named(compression):
    with pytest.raises(DamagedChunkError, match=r"its checksum \(CRC\) is wrong"):
        expand_chunk(record(compression, COMPRESSED[compression], crc=1))


@pytest.mark.parametrize("compression", ["zstd", "lz4"])
def test_damaged_data_is_named(compression):
    data = bytearray(COMPRESSED[compression])
    data[1] ^= 0xFF
    with pytest.raises(DamagedChunkError, match=f"{compression} reports"):
        expand_chunk(record(compression, bytes(data)))


@pytest.mark.parametrize("compression", COMPRESSED)
@pytest.mark.parametrize("error", [-1, 1])
def test_wrong_size_is_named(compression, error):
    with pytest.raises(DamagedChunkError, match="claims|reports"):
        expand_chunk(record(compression, COMPRESSED[compression], size=len(DATA) + error))


def test_unknown_compression_is_named():
    with pytest.raises(DamagedChunkError, match="its compression 'brotli'.*zstd, lz4"):
        expand_chunk(record("brotli", DATA))


@pytest.mark.parametrize("cut", [0, 10, 35, 40])
def test_truncated_head_is_named(cut):
    with pytest.raises(DamagedChunkError, match="has only|truncated"):
        expand_chunk(record("zstd", COMPRESSED["zstd"])[:cut])


def test_data_longer_than_the_record_is_named():
    with pytest.raises(DamagedChunkError, match="it claims 99999 bytes of data and has"):
        expand_chunk(record("zstd", COMPRESSED["zstd"], length=99999))


def test_claim_of_four_gigabytes_is_not_allocated():
    tracemalloc.start()
    with pytest.raises(DamagedChunkError, match="claims 4294967296 bytes of messages, allowed is"):
        expand_chunk(record("zstd", COMPRESSED["zstd"], size=2**32))
    assert tracemalloc.get_traced_memory()[1] < 2**20
    tracemalloc.stop()


def test_claim_inside_the_zstd_frame_is_not_allocated():
    frame = b"\x28\xb5\x2f\xfd\xe0" + struct.pack("<Q", 2**33) + bytes(20)
    assert zstandard.frame_content_size(frame) == 2**33
    with pytest.raises(DamagedChunkError, match="its zstd frame claims 8589934592 bytes, the chunk 10240"):
        expand_chunk(record("zstd", frame))
