from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.records import ChunkIndex, MessageIndex, Statistics, SummaryOffset
from mcap.stream_reader import StreamReader, get_chunk_data_stream

from flexros.logs.mcap.chunk import assemble_chunk
from flexros.logs.mcap.file_writer import McapFileWriter


def chunk_of(times, channels=None, size=50):
    times = np.array(times)
    channels = np.ones(len(times), np.int64) if channels is None else np.array(channels)
    rng = np.random.default_rng(int(times[0]))
    return assemble_chunk(channels, times, times, [rng.bytes(size) for _ in times], {})


@pytest.fixture
def file(tmp_path):
    file = McapFileWriter(tmp_path / "a.mcap")
    file.add_channel("/a", "x/msg/X", "float64 x", {"key": "value"})
    file.add_channel("/b", "x/msg/X", "float64 x", {})
    yield file
    file.close()


def finish(file, path):
    file.finish("rosbag2", {"serialized_metadata": "text"})
    file.close()
    return list(StreamReader(path.open("rb"), emit_chunks=True, validate_crcs=True).records)


def test_records_in_the_order_of_the_specification(file, tmp_path):
    file.append(chunk_of([1, 2]))
    names = [type(record).__name__ for record in finish(file, tmp_path / "a.mcap")]
    assert names == [
        *("Header", "Schema", "Channel", "Channel", "Chunk", "MessageIndex", "Metadata", "DataEnd"),
        *("Schema", "Channel", "Channel", "Statistics", "ChunkIndex", "MetadataIndex"),
        *["SummaryOffset"] * 5,
        "Footer",
    ]


def test_channels_share_their_schema(file, tmp_path):
    finish(file, tmp_path / "a.mcap")
    summary = make_reader((tmp_path / "a.mcap").open("rb")).get_summary()
    assert len(summary.schemas) == 1
    assert [(c.topic, c.schema_id, c.metadata) for c in summary.channels.values()] == [
        ("/a", 1, {"key": "value"}),
        ("/b", 1, {}),
    ]


def test_indexes_point_to_their_messages(file, tmp_path):
    file.append(chunk_of([5, 3, 4], [1, 2, 1]))
    file.append(chunk_of([9, 8], [2, 2]))
    records = finish(file, tmp_path / "a.mcap")
    content = (tmp_path / "a.mcap").read_bytes()
    chunks = [r for r in records if type(r).__name__ == "Chunk"]
    indexes = [r for r in records if isinstance(r, MessageIndex)]
    assert [(i.channel_id, [t for t, _ in i.records]) for i in indexes] == [(1, [4, 5]), (2, [3]), (2, [8, 9])]
    chunk_indexes = [r for r in records if isinstance(r, ChunkIndex)]
    for chunk, summary in zip(chunks, chunk_indexes, strict=True):
        assert content[summary.chunk_start_offset] == Opcode.CHUNK
        assert (summary.message_start_time, summary.message_end_time) == (
            chunk.message_start_time,
            chunk.message_end_time,
        )
        end = summary.chunk_start_offset + summary.chunk_length
        assert min(summary.message_index_offsets.values()) == end
        assert all(content[at] == Opcode.MESSAGE_INDEX for at in summary.message_index_offsets.values())
        assert content[end + summary.message_index_length] in (Opcode.CHUNK, Opcode.METADATA)
        assert get_chunk_data_stream(chunk, validate_crc=True)[1] == summary.uncompressed_size


def test_summary_offsets_point_to_their_groups(file, tmp_path):
    file.append(chunk_of([1, 2]))
    records = finish(file, tmp_path / "a.mcap")
    content = (tmp_path / "a.mcap").read_bytes()
    groups = [r for r in records if isinstance(r, SummaryOffset)]
    assert all(content[group.group_start] == group.group_opcode for group in groups)
    for one, other in pairwise(groups):
        assert one.group_start + one.group_length == other.group_start


def test_statistics(file, tmp_path):
    file.append(chunk_of([5, 3, 4], [1, 2, 1]))
    file.append(chunk_of([9, 8], [2, 2]))
    (statistics,) = [r for r in finish(file, tmp_path / "a.mcap") if isinstance(r, Statistics)]
    assert statistics.channel_message_counts == {1: 2, 2: 3}
    assert (statistics.message_start_time, statistics.message_end_time, statistics.chunk_count) == (3, 9, 2)


def test_empty_file_is_valid(file, tmp_path):
    records = finish(file, tmp_path / "a.mcap")
    (statistics,) = [r for r in records if isinstance(r, Statistics)]
    assert (statistics.message_count, statistics.message_start_time, statistics.message_end_time) == (0, 0, 0)


def test_existing_file_is_kept(file, tmp_path):
    with pytest.raises(FileExistsError):
        McapFileWriter(tmp_path / "a.mcap")


class LimitedDisk:
    """A file that takes only so many bytes, like a full disk: first a part of the data, then an error."""

    def __init__(self, file, limit):
        self._file, self.limit = file, limit

    def write(self, data):
        room = self.limit - self._file.tell()
        if room <= 0:
            raise OSError(28, "No space left on device")
        return self._file.write(data[:room])

    def __getattr__(self, name):
        return getattr(self._file, name)


def limit(file, n_more):
    file._file = LimitedDisk(file._file, file._end + n_more)


def test_chunk_that_does_not_fit_is_truncated_again(file, tmp_path):
    file.append(chunk_of([1, 2]))
    size = (tmp_path / "a.mcap").stat().st_size
    limit(file, 60)
    with pytest.raises(OSError, match="No space left"):
        file.append(chunk_of([3, 4]))
    assert (tmp_path / "a.mcap").stat().st_size == size
    assert file.counts == {1: 2}


def test_last_chunk_makes_room_for_the_summary(file, tmp_path):
    file.append(chunk_of([1, 2]))
    file.append(chunk_of([3, 4, 5], size=2000))
    limit(file, 60)
    with pytest.raises(OSError, match="No space left"):
        file.finish("rosbag2", {})
    assert file.finish_in_less_space("rosbag2", dict)
    file.close()
    with (tmp_path / "a.mcap").open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        assert [m.log_time for _, _, m in reader.iter_messages()] == [1, 2]
        assert reader.get_summary().statistics.channel_message_counts == {1: 2} == dict(file.counts)


def test_last_chunk_is_kept_if_giving_it_up_is_not_enough(file, tmp_path):
    file.append(chunk_of([1, 2]))
    content = (tmp_path / "a.mcap").read_bytes()
    limit(file, 0)
    assert not file.finish_in_less_space("rosbag2", dict)
    assert (tmp_path / "a.mcap").read_bytes() == content
    assert file.counts == {1: 2}


def test_without_chunks_there_is_nothing_to_give_up(file):
    assert not file.finish_in_less_space("rosbag2", dict)
