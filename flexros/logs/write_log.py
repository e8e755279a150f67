"""The direct way to a log: whole time series into a rosbag2 folder, without nodes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.config.topics import load_topics
from flexros.logs.joint_state_message import FIELDS, joint_state_layout
from flexros.logs.pose_stamped_message import pose_stamped_layout
from flexros.logs.time_series import JointSeries, Log, PoseSeries
from flexros.logs.writer import MAX_CHUNK_DURATION, LogWriter

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from numpy.typing import NDArray

    from flexros.arrays import IntArray
    from flexros.logs.message_layout import MessageLayout

_MAX_MESSAGES_PER_CHUNK = 5000  # chosen: about 1 MB before compression


class _Stream:
    """One topic on its way into the log.

    Args:
        topic_id: Number of the topic in the log.
        series: Its time series.
    """

    def __init__(self, topic_id: int, series: JointSeries | PoseSeries) -> None:
        self.topic_id = topic_id
        self.stamp = series.stamp
        self._layout: MessageLayout
        if isinstance(series, JointSeries):
            filled = [field for field in FIELDS if getattr(series, field) is not None]
            self._layout = joint_state_layout(series.names, filled).message
            values = [getattr(series, field) for field in FIELDS]
            self._numbers = [np.empty((len(series.stamp), 0)) if v is None else v for v in values]
        else:
            self._layout = pose_stamped_layout(series.frame_id).message
            self._numbers = [np.hstack((series.position, series.orientation))]

    def payloads(self, begin: int, end: int) -> NDArray[np.object_]:
        """Serialised messages of the stamps in [begin, end), in order."""
        first, last = np.searchsorted(self.stamp, (begin, end))
        messages = self._layout.serialise(self.stamp[first:last], [values[first:last] for values in self._numbers])
        payloads = np.empty(len(messages), object)
        payloads[:] = messages.view(f"V{messages.shape[1]}")[:, 0].tolist()
        return payloads


def _windows(stamp: IntArray) -> Iterator[tuple[int, int]]:
    """Cut stamps in order into chunks that are short enough in time and in number."""
    at = 0
    while at < len(stamp):
        begin = int(stamp[at])
        end = begin + MAX_CHUNK_DURATION
        if at + _MAX_MESSAGES_PER_CHUNK < len(stamp):
            end = min(end, max(int(stamp[at + _MAX_MESSAGES_PER_CHUNK]), begin + 1))
        yield begin, end
        at = int(np.searchsorted(stamp, end))


def write_log(log: Log, folder: Path) -> None:
    """Write a log into a new rosbag2 folder, messages of all topics in the order of their stamps.

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
        for begin, end in _windows(np.sort(np.concatenate([stream.stamp for stream in streams]))):
            parts = [stream.payloads(begin, end) for stream in streams]
            times = [s.stamp[slice(*np.searchsorted(s.stamp, (begin, end)))] for s in streams]
            topic_id = np.repeat([s.topic_id for s in streams], [len(part) for part in parts]).astype(np.int64)
            time = np.concatenate(times)
            order = np.argsort(time, kind="stable")
            writer.write_many(topic_id[order], time[order], np.concatenate(parts)[order].tolist())
