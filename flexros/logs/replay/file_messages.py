"""Messages of one MCAP file in the order of their log times; only messages out of order are held in memory."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass, field
from itertools import accumulate
from operator import itemgetter
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from flexros.logs.bag.reader import bag_file_reader
from flexros.logs.message_block import LENGTH_FIELD_END, MESSAGE_HEADER
from flexros.logs.replay.recorded_topic import RecordedTopic, recorded_topic

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path

    from flexros.logs.message_block import MessageBlock

_HEADER_SIZE = MESSAGE_HEADER.itemsize - LENGTH_FIELD_END
_NEVER = 2**64 - 1


class ReplayMessage(NamedTuple):
    """One message to be played.

    Attributes:
        log_time: Time of recording [ns].
        topic: Index of its topic in the replay.
        payload: Serialised message.
    """

    log_time: int
    topic: int
    payload: bytes


class TimeWindow(NamedTuple):
    """Log times from `first` to `last` [ns], both included."""

    first: int
    last: int


@dataclass
class FileSurvey:
    """Result of one pass through a file.

    Attributes:
        path: The file.
        channels: Topic of each channel, by its number.
        earliest: Earliest log time of each block of messages, in the order of the file [ns].
        latest: Latest log time in the file [ns], -1 without messages.
        warnings: Damage in the file.
    """

    path: Path
    channels: dict[int, RecordedTopic] = field(default_factory=dict)
    earliest: list[int] = field(default_factory=list)
    latest: int = -1
    warnings: list[str] = field(default_factory=list)


def survey_file(path: Path) -> FileSurvey:
    """Read topics, times and damage of a file in one pass.

    Args:
        path: An .mcap file, complete or truncated.

    Raises:
        InputError: It cannot be read or is not MCAP.
    """
    survey = FileSurvey(path)
    reader = bag_file_reader(path)
    counts: dict[int, tuple[int, int]] = {}
    for block in reader.blocks():
        times, channels = block.headers["log_time"], block.headers["channel"]
        survey.earliest.append(int(times.min()) if len(times) else _NEVER)
        survey.latest = max(survey.latest, int(times.max()) if len(times) else -1)
        for number in np.unique(channels).tolist():
            lengths = block.headers["length"][channels == number]
            count, largest = counts.get(number, (0, 0))
            counts[number] = count + len(lengths), max(largest, int(lengths.max()) - _HEADER_SIZE)
    for number, channel in reader.channels.items():
        topic = recorded_topic(channel, reader.schemas.get(channel.schema_id))
        survey.channels[number] = topic.with_messages(*counts.pop(number, (0, 0)))
    survey.warnings.extend(reader.warnings)
    if counts:
        n = sum(count for count, _ in counts.values())
        survey.warnings.append(f"{path}: {n} messages name a channel that is not defined, they were left out")
    return survey


def file_messages(survey: FileSurvey, topics: Mapping[int, int], window: TimeWindow) -> Iterator[ReplayMessage]:
    """Yield the messages of a file in the order of time; messages of equal time keep their order in the file.

    A message is held until no later block has an earlier one.

    Args:
        survey: Result of the first pass.
        topics: Index in the replay of the topic of a channel; other channels are skipped.
        window: Log times to be played.
    """
    held: list[tuple[int, int, int, int, bytes | memoryview]] = []
    # limits[k]: earliest log time of all blocks after block k
    limits = list(accumulate([_NEVER, *survey.earliest[:0:-1]], min))[::-1]
    for block, limit in zip(bag_file_reader(survey.path).blocks(), limits, strict=False):
        held.extend(_selected(block, topics, window))
        held.sort(key=itemgetter(0))
        n = bisect_right(held, limit, key=itemgetter(0))
        for log_time, topic, start, end, data in held[:n]:
            yield ReplayMessage(log_time, topic, bytes(data[start:end]))
        del held[:n]


def _selected(
    block: MessageBlock, topics: Mapping[int, int], window: TimeWindow
) -> Iterator[tuple[int, int, int, int, bytes | memoryview]]:
    """Yield log time, topic, begin and end of the payload, and data of the messages to be played."""
    headers = block.headers
    times = headers["log_time"]
    rows = np.isin(headers["channel"], list(topics)) & (times >= window.first) & (times <= window.last)
    start = block.offsets[rows]
    end = start + headers["length"][rows].astype(np.int64) - _HEADER_SIZE
    channels = headers["channel"][rows].tolist()
    for time, number, a, b in zip(times[rows].tolist(), channels, start.tolist(), end.tolist(), strict=True):
        yield time, topics[number], a, b, block.data
