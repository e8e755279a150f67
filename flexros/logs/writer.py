"""Writing of serialised messages into a rosbag2 folder with MCAP storage."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from flexros.atomic_file import write_whole
from flexros.errors import InputError, RunError, unknown_name
from flexros.logs.bag.metadata import BagMetadata, BagTopic, as_yaml, offered_qos
from flexros.logs.mcap.chunk_thread import ChunkThread
from flexros.logs.mcap.file_writer import McapFileWriter
from flexros.logs.messages.schemas import message_schema
from flexros.logs.provenance_file import PROVENANCE_FILE, provenance_text
from flexros.logs.stamps import NANOSECONDS

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence
    from pathlib import Path
    from types import TracebackType

    from typing_extensions import Self

    from flexros.arrays import IntArray
    from flexros.config.topics import Topic

MAX_CHUNK_DURATION = NANOSECONDS // 2
"""Longest time between the first and the last message of a chunk [ns]: a killed recorder may lose that much."""

MAX_CHUNK_SIZE = 1 << 20
"""Size at which a chunk ends [byte]; chosen as in common recorders, so that players need little memory."""

_LATEST_TIME = 2**63 - 1


class LogWriter:
    """Writes messages into a new rosbag2 folder.

    Messages are collected in memory. A separate thread compresses and writes each chunk, so that `write` costs little
    and does not wait for the disk unless that is several chunks behind. Every written chunk is readable at any time,
    and metadata.yaml names the topics. Use it from one thread.

    Args:
        folder: Folder to create.
        topics: Topics, numbered from 1 in this order.
        provenance: Scenario, seed, versions, model hash: written as JSON into the folder.
        namespace: Prefix of relative topic names.
        chunk_duration: Longest time between the messages of a chunk [ns]; shorter chunks spread the work more evenly.
        share_folders: `share` folders of ROS 2 installations to take message definitions from.

    Raises:
        InputError: The folder exists already or cannot be created, or the type of a topic is not known.
    """

    def __init__(
        self,
        folder: Path,
        topics: Iterable[Topic],
        provenance: Mapping[str, Any],
        *,
        namespace: str = "",
        chunk_duration: int = MAX_CHUNK_DURATION,
        share_folders: Sequence[Path] = (),
    ) -> None:
        if not 0 < chunk_duration <= MAX_CHUNK_DURATION:
            raise InputError(f"chunk_duration is {chunk_duration} ns, allowed is 1 to {MAX_CHUNK_DURATION} ns")
        text = provenance_text(provenance)
        self.folder = folder
        self._share_folders = tuple(share_folders)
        self._namespace = namespace.strip("/")
        self._chunk_duration = chunk_duration
        self._slack = chunk_duration // 10  # messages of different topics may be this much out of order
        self._topics: list[BagTopic] = []
        self._failure: RunError | None = None
        self._closed = False
        self._file = self._create(text)
        self._thread = ChunkThread(self._file)
        self._clear_messages()
        try:
            for topic in topics:
                self._add_channel(topic)
            self._list_topics()
        except BaseException:
            self._thread.stop()
            self._file.close()
            raise

    def _create(self, provenance: str) -> McapFileWriter:
        try:
            self.folder.mkdir(parents=True)
            write_whole(self.folder / PROVENANCE_FILE, provenance)
            return McapFileWriter(self.folder / self.file_name)
        except FileExistsError as error:
            raise InputError(f"the log folder {self.folder} exists already; name another one, or remove it") from error
        except OSError as error:
            raise InputError(
                f"cannot create the log folder {self.folder}: {error.strerror}; name a folder that can be written"
            ) from error

    def _clear_messages(self) -> None:
        """Start a new list of messages."""
        self._messages: list[tuple[int, int, int, bytes]] = []
        self._append = self._messages.append
        self._n_bytes = 0
        self._from_time, self._to_time = 1, 0  # empty window: the next message sets it

    @property
    def file_name(self) -> str:
        """Name of the MCAP file in the folder, as rosbag2 names it."""
        return f"{self.folder.name}_0.mcap"

    @property
    def counts(self) -> dict[str, int]:
        """Number of messages written to the file, by absolute topic name."""
        return {topic.name: self._file.counts.get(number, 0) for number, topic in enumerate(self._topics, 1)}

    def _add_channel(self, topic: Topic) -> None:
        """Add a topic to the file alone; metadata.yaml, which is slow to write, follows once for all of them."""
        schema = message_schema(topic.type, self._share_folders)
        name = topic.name if topic.name.startswith("/") else f"/{self._namespace}/{topic.name}".replace("//", "/")
        entry = BagTopic(name, topic.type, topic.qos, schema.type_hash)
        channel_metadata = {
            "offered_qos_profiles": as_yaml([offered_qos(topic.qos)]),
            "topic_type_hash": schema.type_hash,
        }
        try:
            self._file.add_channel(name, topic.type, schema.text, channel_metadata)
            self._topics.append(entry)
        except OSError as error:
            self._fail(error)

    def _list_topics(self) -> None:
        """Write metadata.yaml with the topics."""
        try:
            self._write_metadata()
        except OSError as error:
            self._fail(error)

    def topic_id(self, name: str) -> int:
        """Return the number of a topic by its absolute or relative name."""
        for number, topic in enumerate(self._topics, 1):
            if topic.name in (name, f"/{name}", f"/{self._namespace}/{name}"):
                return number
        raise unknown_name("topic", name, (topic.name for topic in self._topics), f"the log {self.folder}")

    def write(self, topic_id: int, log_time_ns: int, publish_time_ns: int, payload: bytes) -> None:
        """Write one message.

        Args:
            topic_id: Number of its topic.
            log_time_ns: Log time, the stamp in lock-step [ns].
            publish_time_ns: Publish time [ns].
            payload: Serialised message.

        Raises:
            RunError: An earlier chunk could not be written (the log is readable up to there), or the log is closed.
        """
        self._n_bytes += len(payload)
        if not self._from_time <= log_time_ns <= self._to_time or self._n_bytes > MAX_CHUNK_SIZE:
            self._next_chunk(log_time_ns, len(payload))
        self._append((topic_id, log_time_ns, publish_time_ns, payload))

    def _next_chunk(self, log_time: int, n_bytes: int) -> None:
        self._check_open()
        if not 0 <= log_time <= _LATEST_TIME:
            raise ValueError(f"a log time is {log_time} ns, allowed is 0 to {_LATEST_TIME} ns")
        self._submit()
        self._n_bytes = n_bytes
        self._from_time = max(0, log_time - self._slack)
        self._to_time = min(_LATEST_TIME, self._from_time + self._chunk_duration)

    def write_many(self, topic_id: IntArray, log_time: IntArray, payloads: Sequence[bytes]) -> None:
        """Write messages as one chunk; log times are publish times.

        Args:
            topic_id: Number of the topic of each message, shape (n,).
            log_time: Log times in order, at most 0.5 s in all [ns], shape (n,).
            payloads: Serialised messages, length n.

        Raises:
            RunError: An earlier chunk could not be written (the log is readable up to there), or the log is closed.
        """
        if not len(payloads):
            return
        if np.ptp(log_time) > MAX_CHUNK_DURATION:
            raise ValueError(f"the messages of a chunk span {np.ptp(log_time)} ns, allowed is {MAX_CHUNK_DURATION} ns")
        self._check_open()
        self._submit()
        self._hand_over(topic_id, log_time, log_time, payloads)

    def _check_open(self) -> None:
        if self._failure:
            raise self._failure
        if self._closed:
            raise RunError(f"the log {self.folder} is closed; write before it is closed")

    def _submit(self) -> None:
        """Pass the collected messages to the writing thread."""
        messages = self._messages
        self._clear_messages()
        if messages:
            topic_id, log_time, publish_time, payloads = zip(*messages, strict=True)
            times = np.array((topic_id, log_time, publish_time), np.int64)
            self._hand_over(times[0], times[1], times[2], payloads)

    def _hand_over(self, topic_id: IntArray, log_time: IntArray, publish: IntArray, payloads: Sequence[bytes]) -> None:
        if topic_id.min() < 1 or topic_id.max() > len(self._topics) or log_time.min() < 0 or publish.min() < 0:
            raise ValueError(f"a message has a topic number outside 1 to {len(self._topics)} or a negative time")
        try:
            self._thread.write(topic_id, log_time, publish, payloads)
        except OSError as error:
            self._fail(error)

    def flush(self) -> None:
        """Write all messages received so far; afterwards they survive the end of the process.

        Raises:
            RunError: They could not be written, or the log is closed.
        """
        self._check_open()
        self._submit()
        try:
            self._thread.wait()
        except OSError as error:
            self._fail(error)

    def _bag_metadata(self) -> BagMetadata:
        counts = self._file.counts
        topics = tuple(replace(t, message_count=counts.get(number, 0)) for number, t in enumerate(self._topics, 1))
        return BagMetadata(self.file_name, topics, *self._file.time_range)

    def _write_metadata(self) -> None:
        self._bag_metadata().write(self.folder)

    def _serialised_metadata(self) -> dict[str, str]:
        return {"serialized_metadata": as_yaml(self._bag_metadata().content())}

    def _fail(self, error: OSError) -> NoReturn:
        """Close the log at the last complete chunk that leaves space for the summary, and raise."""
        self._thread.stop()
        self._clear_messages()
        self._closed = True
        missing = []
        try:
            self._file.finish("rosbag2", self._serialised_metadata())
        except OSError:
            if not self._file.finish_in_less_space("rosbag2", self._serialised_metadata):
                missing.append("summary")
        self._file.close()
        try:
            self._write_metadata()
        except OSError:
            missing.append("up-to-date metadata.yaml")
        count, elapsed = sum(self._file.counts.values()), float(np.ptp(self._file.time_range)) / NANOSECONDS
        note = f" (without {' and '.join(missing)})" if missing else ""
        self._failure = RunError(
            f"cannot write the log {self.folder}: {error.strerror}; its {count} messages up to "
            f"t = {elapsed:.3f} s of the run are readable{note}; make space and run again"
        )
        raise self._failure from error

    def close(self, provenance: Mapping[str, Any] | None = None) -> None:
        """Write the remaining messages, the summary and metadata.yaml. Closing twice has no effect.

        Args:
            provenance: Replaces the initial provenance, e.g. with counts of the finished run.

        Raises:
            RunError: The log cannot be written, e.g. because the disk is full; it is readable up to there.
        """
        if self._closed:
            return
        self.flush()
        self._closed = True
        self._thread.stop()
        try:
            self._file.finish("rosbag2", self._serialised_metadata())
            self._write_metadata()
            if provenance is not None:
                write_whole(self.folder / PROVENANCE_FILE, provenance_text(provenance))
        except OSError as error:
            self._fail(error)
        self._file.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()
