from __future__ import annotations

from io import BytesIO

import numpy as np
from mcap.data_stream import ReadDataStream
from mcap.records import Message

from flexros.logs.mcap.chunk import assemble_chunk

PAYLOADS = [b"first", b"", b"the third one", b"4"]


def make():
    channel, time = np.array([2, 1, 2, 2]), np.array([50, 40, 60, 45])
    return assemble_chunk(channel, time, time + 1, PAYLOADS, {2: 10})


def test_records_are_those_of_the_reference_implementation():
    records, stream = make().records, None
    read = []
    stream = ReadDataStream(BytesIO(records))
    while stream.count < len(records):
        assert stream.read1() == 5
        read.append(Message.read(stream, stream.read8()))
    assert [m.data for m in read] == PAYLOADS
    assert [(m.channel_id, m.log_time, m.publish_time) for m in read] == [
        (2, 50, 51),
        (1, 40, 41),
        (2, 60, 61),
        (2, 45, 46),
    ]
    assert [m.sequence for m in read] == [10, 0, 11, 12]


def test_index_is_sorted_and_points_to_the_records():
    chunk = make()
    assert chunk.index[2]["log_time"].tolist() == [45, 50, 60]
    for channel, entries in chunk.index.items():
        for time, offset in entries.tolist():
            stream = ReadDataStream(BytesIO(chunk.records[offset:]))
            stream.read1()
            message = Message.read(stream, stream.read8())
            assert (message.channel_id, message.log_time) == (channel, time)


def test_times_of_the_chunk():
    chunk = make()
    assert (chunk.start_time, chunk.end_time) == (40, 60)
