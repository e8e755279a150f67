"""Writing of whole time series into a rosbag2 folder, without nodes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.config.topics import load_topics
from flexros.logs.messages.codec import series_codecs
from flexros.logs.writer import MAX_CHUNK_DURATION, LogWriter

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from numpy.typing import NDArray

    from flexros.arrays import IntArray
    from flexros.logs.messages.codec import AbstractSeriesCodec
    from flexros.logs.time_series import Log, Series

_MAX_MESSAGES_PER_CHUNK = 5000  # chosen: about 1 MB before compression


class _Stream:
    """One topic to be written, in the order of its log times.

    Args:
        topic_id: Number of the topic in the log.
        codec: Codec of its message type.
        series: Its time series.
    """

    def __init__(self, topic_id: int, codec: AbstractSeriesCodec[Any], series: Series) -> None:
        self.topic_id = topic_id
        log_time = series.stamp if series.received is None else series.received
        # A range where they are in order, as nearly always: it cuts without a copy of a long log.
        order = slice(None) if np.all(log_time[1:] >= log_time[:-1]) else np.argsort(log_time, kind="stable")
        self.log_time, self._stamp = log_time[order], series.stamp[order]
        self._layout, columns = codec.columns(series)
        self._numbers = [values[order] for values in columns]

    def payloads(self, begin: int, end: int) -> NDArray[np.object_]:
        """Serialised messages of the log times in [begin, end), in order."""
        first, last = np.searchsorted(self.log_time, (begin, end))
        messages = self._layout.serialise(self._stamp[first:last], [values[first:last] for values in self._numbers])
        payloads = np.empty(len(messages), object)
        payloads[:] = messages.view(f"V{messages.shape[1]}")[:, 0].tolist()
        return payloads


def _windows(log_time: IntArray) -> Iterator[tuple[int, int]]:
    """Split sorted log times into chunks that are limited in duration and in number of messages."""
    row = 0
    while row < len(log_time):
        begin = int(log_time[row])
        end = begin + MAX_CHUNK_DURATION
        if row + _MAX_MESSAGES_PER_CHUNK < len(log_time):
            end = min(end, max(int(log_time[row + _MAX_MESSAGES_PER_CHUNK]), begin + 1))
        yield begin, end
        row = int(np.searchsorted(log_time, end))


def write_log(log: Log, folder: Path) -> None:
    """Write a log into a new rosbag2 folder, messages of all topics in the order of their log times.

    The log time of a message is its time of receipt, or its stamp if the series has none. The values that the plant
    reported on /diagnostics are not written.

    Args:
        log: Time series and provenance.
        folder: Folder to create.

    Raises:
        InputError: The folder exists already or cannot be created.
        RunError: The log cannot be written, e.g. because the disk is full; it is readable up to there.
    """
    codecs = series_codecs()
    series = {name: log.series(name) for name, topic in load_topics().items() if topic.type in codecs}
    present = {name: values for name, values in series.items() if values is not None}
    topics = {name: load_topics()[name] for name in present}
    with LogWriter(folder, topics.values(), log.provenance) as writer:
        streams = [_Stream(writer.topic_id(t.name), codecs[t.type], present[name]) for name, t in topics.items()]
        every = np.concatenate([stream.log_time for stream in streams])
        every.sort()
        for begin, end in _windows(every):
            parts = [stream.payloads(begin, end) for stream in streams]
            times = [s.log_time[slice(*np.searchsorted(s.log_time, (begin, end)))] for s in streams]
            topic_id = np.repeat([s.topic_id for s in streams], [len(part) for part in parts]).astype(np.int64)
            time = np.concatenate(times)
            order = np.argsort(time, kind="stable")
            writer.write_many(topic_id[order], time[order], np.concatenate(parts)[order].tolist())
