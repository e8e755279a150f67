"""ROS 2 bags of other robots, decoded by the definitions in the file."""

from __future__ import annotations

import sys
from collections import Counter
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from flexros.errors import InputError
from flexros.input_limits import MOST_SIGNALS
from flexros.logs.bag.files import find_bag_files
from flexros.logs.bag.reader import BagFileReader, bag_file_reader
from flexros.logs.cdr_cursor import MessageError
from flexros.logs.foreign.message_numbers import message_numbers
from flexros.logs.foreign.signal_source import BAG_SUFFIXES, AbstractSignalSource, Signal
from flexros.logs.messages.bulk_decode import payloads_of
from flexros.logs.messages.foreign_definition import decoder
from flexros.logs.skipped_messages import SkippedMessages
from flexros.logs.stamps import NANOSECONDS

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence
    from pathlib import Path

    from flexros.arrays import FloatArray, IntArray

    Decode = Callable[[bytes], Any]

LOOKED_AT = 100
"""Number of messages of a topic that are searched for names (chosen): several senders may alternate on one topic."""


class RosBag(AbstractSignalSource):
    """Numbers of all messages; the name of a signal is topic, dot, and the name by `message_numbers`.

    Times are those of header.stamp, or the times of recording if the type has no header or stamps are not set.
    """

    format: ClassVar[str] = "ROS 2 bag"
    suffixes: ClassVar[tuple[str, ...]] = BAG_SUFFIXES

    def __init__(self, path: Path) -> None:
        self._path = path
        self._bag = find_bag_files(path)
        self._topic_of: dict[str, str] = {}
        for topic, _, payload, decode in self._messages(None, [], LOOKED_AT):
            try:
                message = decode(payload)
            except MessageError:
                continue
            if len(self._topic_of) < MOST_SIGNALS:
                self._topic_of.update({f"{topic}.{name}": topic for name in message_numbers(message)})

    @property
    def names(self) -> tuple[str, ...]:
        """Signals that the first messages of each topic have, in the order of the file."""
        return tuple(self._topic_of)

    def read(self, names: Sequence[str]) -> dict[str, Signal]:
        """Read signals; see `AbstractSignalSource.read`."""
        names_by_topic: dict[str, list[str]] = {}
        for name in names:
            names_by_topic.setdefault(self._topic_of[name], []).append(name)
        series = {topic: _TopicSeries(topic, topic_names) for topic, topic_names in names_by_topic.items()}
        notes = list(self._bag.warnings)
        for topic, log_time, payload, decode in self._messages(set(names_by_topic), notes):
            series[topic].take(log_time, payload, decode)
        times = {topic: topic_series.times() for topic, topic_series in series.items()}
        origin = min(int(time.min()) for time in times.values() if len(time))
        read: dict[str, Signal] = {}
        for topic, topic_series in series.items():
            read |= topic_series.signals(times[topic], origin, tuple(notes))
            notes = []  # notes on the whole bag are reported once
        return read

    def text(self, topic: str) -> str:
        """Return the first text of a topic of std_msgs/String in any namespace, empty for none.

        Args:
            topic: Last part of its name, such as "robot_description".
        """
        for name, _, payload, decode in self._messages(None, [], 1):
            if name.rsplit("/", 1)[-1] != topic:
                continue
            try:
                text = getattr(decode(payload), "data", "")
            except MessageError:
                continue
            if isinstance(text, str) and text:
                return text
        return ""

    def _messages(
        self, topics: set[str] | None, notes: list[str], most: int = sys.maxsize
    ) -> Iterator[tuple[str, int, bytes, Decode]]:
        """Yield topic, time of recording [ns], payload and decoder of the first messages of each topic."""
        seen: Counter[str] = Counter()
        for file in self._bag.files:
            reader = bag_file_reader(file)
            decoders: dict[int, Decode | None] = {}
            for block in reader.blocks():
                for number in np.unique(block.headers["channel"]).tolist():
                    channel = reader.channels.get(number)
                    topic = "" if channel is None else "/" + channel.topic.strip("/")
                    if channel is None or (topics is not None and topic not in topics):
                        continue
                    if channel.schema_id not in decoders:
                        decoders[channel.schema_id] = _decoder(reader, channel.schema_id, channel.message_encoding)
                    if (decode := decoders[channel.schema_id]) is None:
                        continue
                    rows = np.flatnonzero(block.headers["channel"] == number)[: most - seen[topic]]
                    seen[topic] += len(rows)
                    log_times = block.headers["log_time"][rows].tolist()
                    for time, payload in zip(log_times, payloads_of(block, rows), strict=True):
                        yield topic, time, payload, decode
            notes.extend(reader.warnings)


def _decoder(reader: BagFileReader, schema_id: int, encoding: str) -> Decode | None:
    """Return the decoder of a schema; None if its messages are not CDR or the file does not define them."""
    schema = reader.schemas.get(schema_id)
    if schema is None or encoding != "cdr" or not schema.data.strip():
        return None
    try:
        return decoder(schema, str(reader.path))
    except InputError:
        return None  # its topics have no signals, so a request lists the allowed ones


class _TopicSeries:
    """Values of some signals of one topic, with both times of each message."""

    def __init__(self, topic: str, names: Sequence[str]) -> None:
        self._topic = topic
        self._keys = {name: name.removeprefix(f"{topic}.") for name in names}
        self._rows: dict[str, list[int]] = {name: [] for name in names}
        self._values: dict[str, list[float]] = {name: [] for name in names}
        self._log_times: list[int] = []
        self._stamps: list[int] = []
        self._damaged = SkippedMessages()

    def take(self, log_time: int, payload: bytes, decode: Decode) -> None:
        """Decode a message with its time of recording [ns]."""
        try:
            message = decode(payload)
        except MessageError as error:
            self._damaged.add(str(error))
            return
        numbers = message_numbers(message)
        row = len(self._log_times)
        self._log_times.append(log_time)
        self._stamps.append(_stamp(message))
        for name, key in self._keys.items():
            if key in numbers:
                self._rows[name].append(row)
                self._values[name].append(numbers[key])

    @property
    def _stamped(self) -> bool:
        return all(self._stamps)

    def times(self) -> IntArray:
        """Return the times of the messages [ns], shape (n,): stamps if all are set, else times of recording."""
        return np.array(self._stamps if self._stamped else self._log_times, np.int64)

    def signals(self, times: IntArray, origin: int, notes: tuple[str, ...]) -> dict[str, Signal]:
        """Return the signals in order of time for messages at these times [ns]; the first one has the notes."""
        notes = (*notes, *self._notes())
        signals = {}
        for name, rows in self._rows.items():
            own = times[rows]
            order = np.unique(own, return_index=True)[1]
            if (n_repeats := len(own) - len(order)) > 0:
                notes += (f"{name}: {n_repeats} values with a repeated time were left out",)
            values: FloatArray = np.array(self._values[name])[order]
            time: FloatArray = np.asarray((own[order] - origin) * 1e-9, dtype=np.float64)
            signals[name] = Signal(values, time, origin, notes)
            notes = ()
        return signals

    def _notes(self) -> tuple[str, ...]:
        notes = []
        if not self._stamped:
            notes.append(f"{self._topic} has no header.stamp, or one that is not set: times of recording are used")
        if self._damaged.number:
            notes.append(
                f"{self._topic}: {self._damaged.number} messages were left out (the first: {self._damaged.first})"
            )
        return tuple(notes)


def _stamp(message: Any) -> int:
    """Return the stamp of a message [ns]; 0 if it has none or it is not set."""
    stamp = getattr(getattr(message, "header", None), "stamp", None)
    return 0 if stamp is None else int(stamp.sec) * NANOSECONDS + int(stamp.nanosec)
