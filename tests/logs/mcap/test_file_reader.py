from __future__ import annotations

import struct

import numpy as np
import pytest
import zstandard
from mcap.writer import CompressionType, IndexType, Writer

from flexros.errors import InputError
from flexros.input_limits import EXPANSION_ALLOWANCE, LARGEST_DEFINITIONS, MOST_DEFINITIONS, MOST_WARNINGS
from flexros.logs.mcap.file_reader import McapFileReader

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
    reader = McapFileReader(path)
    messages = []
    for block in reader.blocks():
        for header, offset in zip(block.headers, block.offsets.tolist(), strict=True):
            payload = bytes(block.data[offset : offset + int(header["length"]) - 22])
            messages.append((int(header["channel"]), int(header["log_time"]), payload))
    return reader, messages


EXPECTED = [(1 + k % 2, 1000 + k, bytes([k] * (20 + k))) for k in range(N)]


@pytest.mark.parametrize("compression", list(CompressionType))
@pytest.mark.parametrize("chunk_size", [100, 10**6])
def test_chunked_files(tmp_path, compression, chunk_size):
    reader, messages = read(write(tmp_path / "a.mcap", compression=compression, chunk_size=chunk_size))
    assert sorted(messages, key=lambda m: m[1]) == EXPECTED
    assert reader.warnings == []
    assert {c.topic for c in reader.channels.values()} == {"/a", "/b"}


def test_file_without_chunks_indexes_and_summary(tmp_path):
    options = {"use_chunking": False, "index_types": IndexType.NONE, "use_statistics": False}
    options |= {"repeat_channels": False, "repeat_schemas": False, "use_summary_offsets": False}
    reader, messages = read(write(tmp_path / "a.mcap", **options))
    assert messages == EXPECTED
    assert reader.warnings == []


def test_attachments_and_unknown_records_are_skipped(tmp_path):
    path = write(tmp_path / "a.mcap", chunk_size=100)
    content = path.read_bytes()
    path.write_bytes(content[:8] + struct.pack("<BQ", 0x99, 3) + b"abc" + content[8:])
    assert sorted(read(path)[1], key=lambda m: m[1]) == EXPECTED


def chunk_ends(path):
    from mcap.reader import make_reader

    with path.open("rb") as stream:
        chunks = make_reader(stream).get_summary().chunk_indexes
    return [c.chunk_start_offset + c.chunk_length for c in sorted(chunks, key=lambda c: c.chunk_start_offset)]


def test_truncated_anywhere_gives_every_message_of_complete_chunks(tmp_path):
    path = write(tmp_path / "a.mcap", chunk_size=400)
    content, ends = path.read_bytes(), chunk_ends(path)
    complete: dict[int, int] = {}
    for cut in range(40, max(ends) + 40, 7):
        path.write_bytes(content[:cut])
        reader, messages = read(path)
        assert messages == EXPECTED[: len(messages)]
        n_chunks = sum(end <= cut for end in ends)
        complete.setdefault(n_chunks, len(messages))
        assert complete[n_chunks] == len(messages), "the number depends on the complete chunks alone"
        assert any("truncated at byte" in w or "has no end record" in w for w in reader.warnings)
    assert complete[len(ends)] == N


def test_damaged_chunk_is_named_and_the_others_are_read(tmp_path):
    path = write(tmp_path / "a.mcap", chunk_size=400, compression=CompressionType.NONE)
    content, ends = bytearray(path.read_bytes()), chunk_ends(path)
    content[ends[2] - 1] ^= 0xFF
    path.write_bytes(content)
    reader, messages = read(path)
    assert len(reader.warnings) == 1
    assert "chunk 2 at byte" in reader.warnings[0]
    assert reader.warnings[0].endswith("is damaged and was left out: its checksum (CRC) is wrong")
    assert 0 < N - len(messages) < N // 2


def test_record_inside_a_chunk_that_claims_too_much(tmp_path):
    path = write(tmp_path / "a.mcap", enable_crcs=False, compression=CompressionType.NONE)
    content = path.read_bytes()
    length = struct.pack("<Q", 22 + 20 + 10)
    at = content.index(b"\x05" + length) + 1
    path.write_bytes(content[:at] + struct.pack("<Q", 2**62) + content[at + 8 :])
    reader, messages = read(path)
    assert messages == EXPECTED[:10]
    (warning,) = reader.warnings
    assert "chunk 0 at byte" in warning
    assert "truncated inside, at its byte" in warning


def test_message_too_short_for_its_head(tmp_path):
    path = write(tmp_path / "a.mcap", use_chunking=False)
    content = path.read_bytes()
    path.write_bytes(content[:8] + struct.pack("<BQ", 5, 4) + b"abcd" + content[8:])
    reader, messages = read(path)
    assert messages == EXPECTED
    assert any("1 message records are too short" in warning for warning in reader.warnings)


def test_damaged_channel_is_named(tmp_path):
    path = write(tmp_path / "a.mcap", use_chunking=False)
    content = path.read_bytes()
    path.write_bytes(content[:8] + struct.pack("<BQ", 4, 3) + b"abc" + content[8:])
    reader, messages = read(path)
    assert messages == EXPECTED
    assert any("the record at byte 8 is damaged and was left out" in warning for warning in reader.warnings)


def chunk(records):
    packed = zstandard.compress(records)
    head = struct.pack("<QQQII", 0, 0, len(records), 0, 4) + b"zstd" + struct.pack("<Q", len(packed))
    return struct.pack("<BQ", 6, len(head) + len(packed)) + head + packed


def message(payload=b"", channel=1):
    return struct.pack("<BQHIQQ", 5, 22 + len(payload), channel, 0, 1000, 0) + payload


def put_before_the_end(path, addition):
    content, end = path.read_bytes(), chunk_ends(path)[-1]
    path.write_bytes(content[:end] + addition + content[end:])


@pytest.mark.parametrize(
    ("foreign", "described"),
    [
        (struct.pack("<BQ", 0, 0), "opcode 0, 0 bytes"),
        (struct.pack("<BQ", 5, 0), "opcode 5, 0 bytes"),
        (chunk(message()), "opcode 6, "),
        (struct.pack("<BQ", 0x99, 3) + b"abc", "opcode 153, 3 bytes"),
    ],
    ids=["empty", "empty message", "chunk", "unknown"],
)
def test_what_does_not_belong_into_a_chunk_ends_it(tmp_path, foreign, described):
    path = write(tmp_path / "a.mcap", chunk_size=10**6)
    put_before_the_end(path, chunk(message(b"one") + foreign + message(b"two")))
    reader, messages = read(path)
    assert messages == [*EXPECTED, (1, 1000, b"one")]
    (warning,) = reader.warnings
    assert "chunk 1 at byte" in warning
    assert f"not allowed in a chunk ({described}" in warning


def test_chunks_that_expand_beyond_reason_are_left_out(tmp_path):
    path = write(tmp_path / "a.mcap", chunk_size=400)
    n_before = len(chunk_ends(path))
    bomb = chunk(message(bytes(EXPANSION_ALLOWANCE * 3 // 4)))
    put_before_the_end(path, 3 * bomb + chunk(message(b"small")))
    reader, messages = read(path)
    sizes = [len(payload) for _, _, payload in messages[N:]]
    assert messages[:N] == EXPECTED
    assert sizes == [EXPANSION_ALLOWANCE * 3 // 4, 5]
    (warning,) = reader.warnings
    assert "its chunks expand to more than 200 times" in warning
    assert warning.endswith(f": 2 of {n_before + 4} chunks were left out")


def test_a_chunk_beyond_the_largest_size_is_left_out(tmp_path):
    path = write(tmp_path / "a.mcap", chunk_size=10**6)
    put_before_the_end(path, chunk(bytes(2**26 + 1)))
    reader, messages = read(path)
    assert messages == EXPECTED
    assert reader.warnings[0].endswith("it claims 67108865 bytes of messages, allowed is 67108864")


def test_the_number_of_definitions_is_bounded(tmp_path):
    def channel(number):
        record = struct.pack("<HHIII", number, 1, 0, 0, 0)
        return struct.pack("<BQ", 4, len(record)) + record

    path = write(tmp_path / "a.mcap", chunk_size=10**6)
    put_before_the_end(path, chunk(b"".join(channel(10 + k) for k in range(MOST_DEFINITIONS + 1000)) + message(b"x")))
    reader, messages = read(path)
    assert messages == [*EXPECTED, (1, 1000, b"x")]
    assert len(reader.channels) + len(reader.schemas) == MOST_DEFINITIONS
    (warning,) = reader.warnings
    assert f"defines more than {MOST_DEFINITIONS} types and topics" in warning


def test_size_of_definitions_is_bounded(tmp_path):
    def schema(number):
        text = struct.pack("<I", 10**6) + bytes([number]) * 10**6
        record = struct.pack("<H", number) + struct.pack("<I", 0) * 2 + text
        return struct.pack("<BQ", 3, len(record)) + record

    path = write(tmp_path / "a.mcap", chunk_size=10**6)
    n_before = len(read(path)[0].schemas)
    put_before_the_end(path, chunk(b"".join(schema(10 + k) for k in range(8)) + message(b"x")))
    reader, messages = read(path)
    assert messages == [*EXPECTED, (1, 1000, b"x")]
    assert len(reader.schemas) - n_before == LARGEST_DEFINITIONS // 10**6
    assert f"or more than {LARGEST_DEFINITIONS} bytes of them: the rest is unread" in reader.warnings[0]


def test_damage_at_many_places_is_counted(tmp_path):
    path = write(tmp_path / "a.mcap", chunk_size=10**6)
    put_before_the_end(path, (MOST_WARNINGS + 5) * struct.pack("<BQ", 6, 0))
    reader, messages = read(path)
    assert messages == EXPECTED
    assert len(reader.warnings) == MOST_WARNINGS + 1
    assert reader.warnings[-1].endswith("has damage at 5 further positions")


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
