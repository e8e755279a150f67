"""The direct way to a log: whole time series into a rosbag2 folder, without nodes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.config.topics import load_topics
from flexros.logs.messages.joint_state import FIELDS, joint_state_layout
from flexros.logs.messages.pose_stamped import pose_stamped_layout
from flexros.logs.time_series import JointSeries, Log, PoseSeries
from flexros.logs.writer import MAX_CHUNK_DURATION, LogWriter

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from numpy.typing import NDArray

    from flexros.arrays import IntArray
    from flexros.logs.messages.layout import MessageLayout

_MAX_MESSAGES_PER_CHUNK = 5000  # chosen: about 1 MB before compression


class _Stream:
    """One topic on its way into the log, in the order of its log times.

    Args:
        topic_id: Number of the topic in the log.
        series: Its time series.
    """

    def __init__(self, topic_id: int, series: JointSeries | PoseSeries) -> None:
        self.topic_id = topic_id
        log_time = series.stamp if series.received is None else series.received
        order = np.argsort(log_time, kind="stable")
        self.log_time, self._stamp = log_time[order], series.stamp[order]
        self._layout: MessageLayout
        if isinstance(series, JointSeries):
            filled = [field for field in FIELDS if getattr(series, field) is not None]
            self._layout = joint_state_layout(series.names, filled).message
            values = [getattr(series, field) for field in FIELDS]
            self._numbers = [np.empty((len(series.stamp), 0)) if v is None else v[order] for v in values]
        else:
            self._layout = pose_stamped_layout(series.frame_id).message
            self._numbers = [np.hstack((series.position, series.orientation))[order]]

    def payloads(self, begin: int, end: int) -> NDArray[np.object_]:
        """Serialised messages of the log times in [begin, end), in order."""
        first, last = np.searchsorted(self.log_time, (begin, end))
        messages = self._layout.serialise(self._stamp[first:last], [values[first:last] for values in self._numbers])
        payloads = np.empty(len(messages), object)
        payloads[:] = messages.view(f"V{messages.shape[1]}")[:, 0].tolist()
        return payloads


def _windows(log_time: IntArray) -> Iterator[tuple[int, int]]:
    """Cut log times in order into chunks that are short enough in time and in number."""
    at = 0
    while at < len(log_time):
        begin = int(log_time[at])
        end = begin + MAX_CHUNK_DURATION
        if at + _MAX_MESSAGES_PER_CHUNK < len(log_time):
            end = min(end, max(int(log_time[at + _MAX_MESSAGES_PER_CHUNK]), begin + 1))
        yield begin, end
        at = int(np.searchsorted(log_time, end))


def write_log(log: Log, folder: Path) -> None:
    """Write a log into a new rosbag2 folder, messages of all topics in the order of their log times.

    The log time of a message is when it was received, its stamp where the series tells no other. What the plant said on
    /diagnostics is not written.

    Args:
        log: Time series and provenance.
        folder: Folder to create.

    Raises:
        InputError: The folder exists already or cannot be created.
        RunError: The disk refuses; the log up to there is readable.
    """
    topics = [topic for name, topic in load_topics().items() if getattr(log, name, None) is not None]
    with LogWriter(folder, topics, log.provenance) as writer:
        streams = [_Stream(writer.topic_id(topic.name), getattr(log, topic.name)) for topic in topics]
        for begin, end in _windows(np.sort(np.concatenate([stream.log_time for stream in streams]))):
            parts = [stream.payloads(begin, end) for stream in streams]
            times = [s.log_time[slice(*np.searchsorted(s.log_time, (begin, end)))] for s in streams]
            topic_id = np.repeat([s.topic_id for s in streams], [len(part) for part in parts]).astype(np.int64)
            time = np.concatenate(times)
            order = np.argsort(time, kind="stable")
            writer.write_many(topic_id[order], time[order], np.concatenate(parts)[order].tolist())
