"""Reading of logs from any recorder: rosbag2 folders, .mcap and .db3 files with topics of `topics.yaml`."""

from __future__ import annotations

import ctypes
from collections import Counter
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.config.topics import load_topics
from flexros.errors import InputError
from flexros.logs.bag.files import find_bag_files
from flexros.logs.bag.reader import BagFileReader, bag_file_reader
from flexros.logs.cdr_cursor import MessageError
from flexros.logs.messages.bulk_decode import TopicDecoder, payloads_of
from flexros.logs.messages.codec import codec_of, series_codecs
from flexros.logs.messages.foreign_definition import is_common, translator
from flexros.logs.messages.series_assembly import assemble_series
from flexros.logs.skipped_messages import SkippedMessages
from flexros.logs.time_series import OWN_SERIES, Log
from flexros.one_line import one_line

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterable

    from mcap.records import Channel, Schema

    from flexros.config.topics import Topic
    from flexros.logs.time_series import Series

_DIAGNOSTICS = "diagnostics"
_PLANT = "plant"
"""Name, without namespace, of the node that reports how the loop ran."""


def _contract_topics() -> dict[str, Topic]:
    """Return the recorded topics that become time series of a Log, by name."""
    return {name: topic for name, topic in load_topics().items() if topic.recorded and topic.type in series_codecs()}


def read_log(path: Path | str, namespace: str | None = None, *, leave_out: Collection[str] = ()) -> Log:
    """Read a log.

    Messages may be in any order, mixed with other topics, in several files and in any chunk compression; they are
    decoded by the definitions in the file. A truncated file is read up to its last complete chunk. The warnings of the
    log list everything that was left out or repaired.

    Args:
        path: A rosbag2 folder, an .mcap or a .db3 file.
        namespace: Namespace of the topics, e.g. "robot1" or "" for none; None if the file has only one.
        leave_out: Relative names of topics that are not decoded, as those of a long log need memory.

    Returns:
        The log.

    Raises:
        InputError: There is no such log, it lacks a required topic, or several namespaces have it.
    """
    bag = find_bag_files(Path(path))
    contract = {name: topic for name, topic in _contract_topics().items() if name not in leave_out}
    content = _BagContent(contract)
    for file in bag.files:
        content.read(bag_file_reader(file))
    prefix = content.choose_namespace(path, namespace)
    warnings = [*bag.warnings, *content.warnings]
    series: dict[str, Any] = {}
    used = set()
    for name, topic in contract.items():
        full_name = f"{prefix}/{name}"
        decoder = content.decoders.pop(full_name, None)
        if decoder is not None:
            used.add(full_name)
            found = assemble_series(series_codecs()[topic.type], full_name, decoder, warnings)
            series[name] = None if found is None else _sharing_stamps(found, series.values())
            del decoder
            give_memory_back()
        elif full_name in content.refused:
            warnings.append(content.refused[full_name])
        if topic.required and series.get(name) is None:
            raise content.missing_topic(path, full_name, topic, warnings)
    others = {name: count for name, count in sorted(content.counts.items()) if name not in used}
    return Log(
        **{name: values for name, values in series.items() if name in OWN_SERIES},
        other_series={name: v for name, v in series.items() if name not in OWN_SERIES and v is not None},
        provenance=bag.provenance,
        warnings=tuple(map(one_line, warnings)),
        other_topics=others,
        plant_figures=content.figures.get(f"{prefix}/{_PLANT}".strip("/"), {}),
    )


def _sharing_stamps(series: Series, before: Iterable[Series | None]) -> Series:
    """Return a series with the array of stamps of an earlier one where both are equal, as in lock-step."""
    for other in before:
        if other is not None and np.array_equal(series.stamp, other.stamp):
            return replace(series, stamp=other.stamp)  # type: ignore[type-var]
    return series


def give_memory_back() -> None:
    """Return freed memory to the system: the C library keeps that of many small arrays, here as much as the log."""
    with suppress(OSError, AttributeError):  # another C library
        ctypes.CDLL(None).malloc_trim(0)


@dataclass
class _BagContent:
    """Content of the files of a log.

    Attributes:
        contract: Topics that become time series, by relative name.
        decoders: Decoded messages of the topics with such a name, by absolute name.
        counts: Number of messages of every topic, by absolute name.
        types: Message type of every topic.
        refused: Why a topic with such a name was not decoded.
        warnings: Damage in the files.
        figures: Values that each node called plant reported on /diagnostics, by name of the node, then by key.
    """

    contract: dict[str, Topic]
    decoders: dict[str, TopicDecoder[Any]] = field(default_factory=dict)
    counts: Counter[str] = field(default_factory=Counter)
    types: dict[str, str] = field(default_factory=dict)
    refused: dict[str, str] = field(default_factory=dict)
    warnings: list[str] = field(default_factory=list)
    figures: dict[str, dict[str, float]] = field(default_factory=dict)

    def read(self, reader: BagFileReader) -> None:
        """Decode all messages of a file."""
        translators: dict[int, Callable[[bytes], bytes] | None] = {}
        n_unknown = 0
        unusable = SkippedMessages()
        for block in reader.blocks():
            for number in np.unique(block.headers["channel"]).tolist():
                rows = np.flatnonzero(block.headers["channel"] == number)
                channel = reader.channels.get(number)
                if channel is None:
                    n_unknown += len(rows)
                    continue
                name = "/" + channel.topic.strip("/")
                self.counts[name] += len(rows)
                if name == f"/{_DIAGNOSTICS}":
                    self._take_figures(payloads_of(block, rows), channel, reader, unusable)
                elif (schema := self._accept(name, channel, reader)) is not None:
                    if schema.id not in translators:
                        translators[schema.id] = self._translator(schema, reader)
                    self.decoders[name].add(block, rows, translators[schema.id])
        for channel in reader.channels.values():
            self.counts.setdefault("/" + channel.topic.strip("/"), 0)
        self.warnings.extend(reader.warnings)
        if n_unknown:
            self.warnings.append(
                f"{reader.path}: {n_unknown} messages name a channel that is not defined, they were left out"
            )
        if unusable.number:
            self.warnings.append(
                f"/{_DIAGNOSTICS}: {unusable.number} messages were left out, so the pace of the loop may be unknown "
                f"(the first: {unusable.first})"
            )

    def _take_figures(
        self, payloads: list[bytes], channel: Channel, reader: BagFileReader, unusable: SkippedMessages
    ) -> None:
        """Store what nodes called plant report; a later message replaces the values of an earlier one."""
        codec = codec_of(load_topics()[_DIAGNOSTICS].type)
        schema = reader.schemas.get(channel.schema_id)
        self.types[f"/{_DIAGNOSTICS}"] = name = schema.name if schema else "unknown type"
        if schema is None or name != codec.type or channel.message_encoding != "cdr":
            unusable.add(f"it is a {name} in '{channel.message_encoding}'", len(payloads))
            return
        if schema.data.strip() and not is_common(schema):
            unusable.add(f"its definition of {name} is not that of ROS 2 Jazzy", len(payloads))
            return
        for payload in payloads:
            try:
                statuses = codec.read(payload)
            except MessageError as error:
                unusable.add(str(error))
                continue
            for status in statuses:
                node = status.name.strip("/")
                if node.rsplit("/", 1)[-1] == _PLANT:
                    self.figures.setdefault(node, {}).update(status.numbers())

    def _translator(self, schema: Schema, reader: BagFileReader) -> Callable[[bytes], bytes] | None:
        if not schema.data.strip():
            self.warnings.append(
                f"{reader.path}: {schema.name} has no definition in the file, that of ROS 2 Jazzy is used"
            )
            return None
        return None if is_common(schema) else translator(series_codecs()[schema.name], schema, str(reader.path))

    def _accept(self, name: str, channel: Channel, reader: BagFileReader) -> Schema | None:
        """Return the schema of a topic to be decoded; None for other topics and for unusable ones."""
        topic = self.contract.get(name.rsplit("/", 1)[1])
        schema = reader.schemas.get(channel.schema_id)
        self.types[name] = schema.name if schema else "unknown type"
        if topic is None:
            return None
        if schema is None or schema.name != topic.type:
            self.refused[name] = f"{name} has the type {self.types[name]}, allowed is {topic.type}; it was left out"
            return None
        if channel.message_encoding != "cdr":
            self.refused[name] = f"{name} is encoded as '{channel.message_encoding}', allowed is cdr; it was left out"
            return None
        if name not in self.decoders:
            self.decoders[name] = TopicDecoder(series_codecs()[topic.type].read)
        return schema

    def choose_namespace(self, path: Path | str, namespace: str | None) -> str:
        """Return the prefix of the topic names: "" or "/robot1".

        Raises:
            InputError: Several namespaces have the required topics.
        """
        if namespace is not None:
            return f"/{namespace.strip('/')}" if namespace.strip("/") else ""
        required = next(name for name, topic in self.contract.items() if topic.required)
        prefixes = sorted(name.rsplit("/", 1)[0] for name in self.decoders if name.rsplit("/", 1)[1] == required)
        if len(prefixes) > 1:
            present = ", ".join(f"'{prefix.strip('/')}'" for prefix in prefixes)
            raise InputError(
                f"{path} has the topic {required} in the namespaces {present}; choose one with the argument namespace"
            )
        return prefixes[0] if prefixes else ""

    def missing_topic(self, path: Path | str, name: str, topic: Topic, warnings: list[str]) -> InputError:
        """Return the error for a required topic that is missing."""
        if warnings and not any(self.counts.values()):
            return InputError(
                f"{path} has no complete message of any topic; {'; '.join(warnings)}; give a whole copy of it, or "
                "record the run again"
            )
        present = ", ".join(f"{n} ({self.types.get(n, 'unknown type')}, {c})" for n, c in sorted(self.counts.items()))
        hints = f"; {'; '.join(warnings)}" if warnings else ""
        return InputError(
            f"{path} has no readable messages of {name} ({topic.type}); it holds {present or 'no topics at all'}"
            f"{hints}; record that topic, or map your own topics to it"
        )
