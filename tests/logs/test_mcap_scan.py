from __future__ import annotations

import struct

import numpy as np
import pytest
from mcap.writer import CompressionType, IndexType, Writer

from flexros.errors import InputError
from flexros.logs.mcap_scan import McapScan

N = 60


def write(path, *, finish=True, **options):
    with path.open("wb") as stream:
        writer = Writer(stream, **options)
        writer.start(profile="ros2")
        schema = writer.register_schema("x/msg/X", "ros2msg", b"float64 x\n")
        channels = [writer.register_channel(f"/{name}", "cdr", schema) for name in "ab"]
        for k in range(N):
            writer.add_message(channels[k % 2], 1000 + k, bytes([k] * (20 + k)), 1000 + k, k)
        if finish:
            writer.finish()
    return path


def read(path):
    scan = McapScan(path)
    messages = []
    for block in scan.blocks():
        for header, offset in zip(block.headers, block.offsets.tolist(), strict=True):
            payload = bytes(block.data[offset : offset + int(header["length"]) - 22])
            messages.append((int(header["channel"]), int(header["log_time"]), payload))
    return scan, messages


EXPECTED = [(1 + k % 2, 1000 + k, bytes([k] * (20 + k))) for k in range(N)]


@pytest.mark.parametrize("compression", list(CompressionType))
@pytest.mark.parametrize("chunk_size", [100, 10**6])
def test_chunked_files(tmp_path, compression, chunk_size):
    scan, messages = read(write(tmp_path / "a.mcap", compression=compression, chunk_size=chunk_size))
    assert sorted(messages, key=lambda m: m[1]) == EXPECTED
    assert scan.warnings == []
    assert {c.topic for c in scan.channels.values()} == {"/a", "/b"}


def test_file_without_chunks_indexes_and_summary(tmp_path):
    options = {"use_chunking": False, "index_types": IndexType.NONE, "use_statistics": False}
    options |= {"repeat_channels": False, "repeat_schemas": False, "use_summary_offsets": False}
    scan, messages = read(write(tmp_path / "a.mcap", **options))
    assert messages == EXPECTED
    assert scan.warnings == []


def test_attachments_and_unknown_records_are_passed_over(tmp_path):
    path = write(tmp_path / "a.mcap", chunk_size=100)
    content = path.read_bytes()
    path.write_bytes(content[:8] + struct.pack("<BQ", 0x99, 3) + b"abc" + content[8:])
    assert sorted(read(path)[1], key=lambda m: m[1]) == EXPECTED


def chunk_ends(path):
    from mcap.reader import make_reader

    with path.open("rb") as stream:
        chunks = make_reader(stream).get_summary().chunk_indexes
    return [c.chunk_start_offset + c.chunk_length for c in sorted(chunks, key=lambda c: c.chunk_start_offset)]


def test_cut_off_anywhere_gives_every_message_of_complete_chunks(tmp_path):
    path = write(tmp_path / "a.mcap", chunk_size=400)
    content, ends = path.read_bytes(), chunk_ends(path)
    complete: dict[int, int] = {}
    for cut in range(40, max(ends) + 40, 7):
        path.write_bytes(content[:cut])
        scan, messages = read(path)
        assert messages == EXPECTED[: len(messages)]
        n_chunks = sum(end <= cut for end in ends)
        complete.setdefault(n_chunks, len(messages))
        assert complete[n_chunks] == len(messages), "the number depends on the complete chunks alone"
        assert any("cut off at byte" in w or "has no end mark" in w for w in scan.warnings)
    assert complete[len(ends)] == N


def test_damaged_chunk_is_named_and_the_others_are_read(tmp_path):
    path = write(tmp_path / "a.mcap", chunk_size=400, compression=CompressionType.NONE)
    content, ends = bytearray(path.read_bytes()), chunk_ends(path)
    content[ends[2] - 1] ^= 0xFF
    path.write_bytes(content)
    scan, messages = read(path)
    assert len(scan.warnings) == 1
    assert "chunk 2 at byte" in scan.warnings[0]
    assert scan.warnings[0].endswith("is damaged and was left out: its checksum (CRC) is wrong")
    assert 0 < N - len(messages) < N // 2


def test_record_inside_a_chunk_that_claims_too_much(tmp_path):
    path = write(tmp_path / "a.mcap", enable_crcs=False, compression=CompressionType.NONE)
    content = path.read_bytes()
    length = struct.pack("<Q", 22 + 20 + 10)
    at = content.index(b"\x05" + length) + 1
    path.write_bytes(content[:at] + struct.pack("<Q", 2**62) + content[at + 8 :])
    scan, messages = read(path)
    assert messages == EXPECTED[:10]
    assert any("is cut off inside chunk 0 at byte" in warning for warning in scan.warnings)


def test_message_too_short_for_its_head(tmp_path):
    path = write(tmp_path / "a.mcap", use_chunking=False)
    content = path.read_bytes()
    path.write_bytes(content[:8] + struct.pack("<BQ", 5, 4) + b"abcd" + content[8:])
    scan, messages = read(path)
    assert messages == EXPECTED
    assert any("1 message records are too short" in warning for warning in scan.warnings)


def test_damaged_channel_is_named(tmp_path):
    path = write(tmp_path / "a.mcap", use_chunking=False)
    content = path.read_bytes()
    path.write_bytes(content[:8] + struct.pack("<BQ", 4, 3) + b"abc" + content[8:])
    scan, messages = read(path)
    assert messages == EXPECTED
    assert any("the record at byte 8 is damaged and was left out" in warning for warning in scan.warnings)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "is empty; give a rosbag2 folder"),
        (b"#ROSBAG V2.0\n", "is not an MCAP file"),
        (b"\x89MC", "is not an MCAP file"),
    ],
)
def test_other_files_are_refused(tmp_path, content, message):
    (tmp_path / "a.mcap").write_bytes(content)
    with pytest.raises(InputError, match=message):
        read(tmp_path / "a.mcap")


def test_unreadable_file_is_named(tmp_path):
    with pytest.raises(InputError, match=r"cannot read .*a.mcap: No such file or directory; give a readable log"):
        read(tmp_path / "a.mcap")


def test_random_damage_never_gives_another_error(tmp_path):
    path = write(tmp_path / "a.mcap", chunk_size=400)
    content = path.read_bytes()
    rng = np.random.default_rng(5)
    for _ in range(150):
        damaged = bytearray(content)
        for at in rng.integers(8, len(content), 3):
            damaged[at] = rng.integers(256)
        path.write_bytes(damaged)
        _, messages = read(path)
        assert len(messages) <= 2 * N
