"""All messages that a replay sends, in order: those of the log, and its own (clock, reference ahead of time)."""

from __future__ import annotations

import heapq
import struct
from dataclasses import dataclass, replace
from operator import attrgetter
from typing import TYPE_CHECKING

from flexros.config.topics import load_topics
from flexros.errors import InputError
from flexros.logs.messages.joint_trajectory import JointTrajectoryCodec
from flexros.logs.replay.controller_feed import ControllerFeed, controller_feed
from flexros.logs.replay.file_messages import ReplayMessage
from flexros.logs.replay.recorded_topic import RecordedTopic, absolute_name
from flexros.logs.replay.source import PlayedTopic, ReplayChoice, ReplaySource
from flexros.logs.stamps import NANOSECONDS

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence
    from pathlib import Path

_CLOCK = "/clock"
_CLOCK_TYPE = "rosgraph_msgs/msg/Clock"
_CLOCK_MESSAGE = struct.Struct("<4BiI")

LATEST_STAMP = 2**31 * NANOSECONDS - 1
"""Latest time that a stamp of ROS 2 can represent [ns]; a damaged log may claim later ones."""

SMALLEST_QUEUE, LARGEST_QUEUE = 10, 2000
"""Limits of the queue of a publisher [messages], chosen: at most one second of a topic at 2 kHz."""

QUEUE_SIZE = 32 * 2**20
"""Largest size of the queue of a publisher [byte], chosen."""


@dataclass(frozen=True)
class FedController:
    """A controller that receives a replay.

    Attributes:
        feed: Its recorded reference and commands.
        states: Index of the topic of the measurements in the playlist.
        chunks: Index of the topic of the reference.
        commands: Absolute name of the topic of its commands.
        sensors: Indices of the topics of further sensors.
    """

    feed: ControllerFeed
    states: int
    chunks: int
    commands: str
    sensors: tuple[int, ...] = ()


class Playlist:
    """Messages and topics of a replay.

    Args:
        path: A rosbag2 folder or an .mcap file.
        choice: Topics and times to be played.
        clock_rate: Messages on /clock per second of the log [Hz]; 0 for none. They carry the log time and replace the
            recorded ones.
        feeds_controller: Send the recorded joint_reference ahead of time on joint_reference_ahead, for a controller
            that answers the recorded measurements; recorded commands and references are not played, unless renamed.

    Attributes:
        source: The log.
        topics: Topics; messages refer to them by their index.
        controller: The controller that is fed, if any.

    Raises:
        InputError: There is no such log, topic or time, or nothing is left to be played.
    """

    def __init__(
        self, path: Path | str, choice: ReplayChoice, *, clock_rate: float = 0.0, feeds_controller: bool = False
    ) -> None:
        made = {_CLOCK: "the replay publishes its own"} if clock_rate else {}
        self._replaced = set(made)
        self._clock_rate = clock_rate
        if not feeds_controller:
            self.source = ReplaySource(path, replace(choice, left_out=made))
            self.topics: Sequence[PlayedTopic] = self.source.topics
            self.controller: FedController | None = None
        else:
            self._feed(path, choice, made)
        if clock_rate:
            self.topics = (*self.topics, _made_topic(_CLOCK, _CLOCK_TYPE, _CLOCK_MESSAGE.size))

    def _feed(self, path: Path | str, choice: ReplayChoice, made: dict[str, str]) -> None:
        prefix = _only_namespace(ReplaySource(path, replace(choice, remaps={}, left_out=made)))
        renamed = {absolute_name(name) for name in choice.remaps}
        own = {f"{prefix}/{name}" for name in ("joint_commands", "joint_reference", "joint_reference_ahead")} - renamed
        left_out = dict.fromkeys(own, "the fed controller or the replay publishes it")
        self._replaced |= own
        self.source = ReplaySource(path, replace(choice, left_out={**made, **left_out}))
        states = next(i for i, t in enumerate(self.source.topics) if t.recorded.name == f"{prefix}/joint_states")
        feed = controller_feed(path, prefix.strip("/"))
        played = self.source.topics[states].name.rsplit("/", 1)[0]
        largest = max(len(chunk.payload) for chunk in feed.chunks)
        ahead = _made_topic(f"{played}/joint_reference_ahead", JointTrajectoryCodec.type, largest)
        self.topics = (*self.source.topics, ahead)
        measured = {f"{prefix}/{name}" for name, topic in load_topics().items() if topic.needs_sensor}
        sensors = tuple(i for i, t in enumerate(self.source.topics) if t.recorded.name in measured)
        self.controller = FedController(feed, states, len(self.source.topics), f"{played}/joint_commands", sensors)

    def messages(self) -> Iterator[ReplayMessage]:
        """Return all messages in the order of log time; at equal times, the replay's own ones precede."""
        streams = [self.source.messages()]
        if self.controller is not None:
            streams.insert(0, self._chunks(self.controller))
        if self._clock_rate:
            streams.insert(0, self._clock())
        return heapq.merge(*streams, key=attrgetter("log_time"))

    def _clock(self) -> Iterator[ReplayMessage]:
        first, last = self.source.window
        step, k = NANOSECONDS / self._clock_rate, 0
        while (time := first + round(k * step)) <= min(last, LATEST_STAMP):
            message = _CLOCK_MESSAGE.pack(0, 1, 0, 0, *divmod(time, NANOSECONDS))
            yield ReplayMessage(time, len(self.topics) - 1, message)
            k += 1

    def _chunks(self, controller: FedController) -> Iterator[ReplayMessage]:
        first, last = self.source.window
        for chunk in controller.feed.chunks:
            if chunk.last_stamp >= first or self.source.window.first == self.source.beginning:
                yield ReplayMessage(min(max(chunk.log_time, first), last), controller.chunks, chunk.payload)

    def playable(self, refusal: Callable[[PlayedTopic], str]) -> tuple[dict[int, PlayedTopic], dict[str, str]]:
        """Separate the topics that can be published here from the others.

        Args:
            refusal: Returns why a topic cannot be published; empty if it can.

        Returns:
            Topics by index, and why each of the others is left out, by name in the log, without those that the replay
            replaces on request.

        Raises:
            InputError: None is left.
        """
        refusals = {i: refusal(topic) for i, topic in enumerate(self.topics)}
        left_out = {self.topics[i].recorded.name: why for i, why in refusals.items() if why}
        left = {i: topic for i, topic in enumerate(self.topics) if not refusals[i]}
        if not any(topic in left.values() for topic in self.source.topics):
            why = "; ".join(f"{name}: {reason}" for name, reason in left_out.items())
            raise InputError(f"no topic of {self.source.path} can be played here: {why}")
        not_played = {name: why for name, why in self.source.not_played.items() if name not in self._replaced}
        return left, {**not_played, **left_out}


def queue_depth(topic: RecordedTopic) -> int:
    """Number of messages that the publisher of a topic keeps, fewer of large ones."""
    return min(max(QUEUE_SIZE // max(topic.largest, 1), SMALLEST_QUEUE), LARGEST_QUEUE)


def _made_topic(name: str, type_name: str, largest: int) -> PlayedTopic:
    return PlayedTopic(RecordedTopic(name, type_name, largest=largest), name)


def _only_namespace(source: ReplaySource) -> str:
    """Prefix of the one topic of measurements."""
    names = [topic.recorded.name for topic in source.topics if topic.recorded.name.endswith("/joint_states")]
    if len(names) != 1:
        present = ", ".join(names) or "none"
        raise InputError(
            f"to feed a controller from {source.path} one topic joint_states is needed, there is {present}; choose one"
        )
    return names[0].removesuffix("/joint_states")
