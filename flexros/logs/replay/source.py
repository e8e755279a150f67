"""A log as a stream of messages in the order of time, with choice of topics, names and times."""

from __future__ import annotations

import heapq
import math
from dataclasses import dataclass, field
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING

from flexros.errors import InputError, unknown_name
from flexros.logs.bag.files import find_bag_files
from flexros.logs.replay.file_messages import ReplayMessage, TimeWindow, file_messages, survey_file
from flexros.logs.replay.recorded_topic import absolute_name, name_problem
from flexros.logs.stamps import NANOSECONDS

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from flexros.logs.replay.file_messages import FileSurvey
    from flexros.logs.replay.recorded_topic import RecordedTopic


@dataclass(frozen=True)
class PlayedTopic:
    """A topic of the replay.

    Attributes:
        recorded: The topic as it is in the log.
        name: Absolute name under which it is played.
    """

    recorded: RecordedTopic
    name: str


@dataclass(frozen=True)
class ReplayChoice:
    """Topics, names and times of a log to be played.

    Attributes:
        topics: Names of topics, all if empty.
        remaps: New names by name.
        start: Begin of the replay, from the beginning of the log [s].
        end: End of the replay, from the beginning of the log [s]; None for the end of the log.
        left_out: Reason to exclude a topic that could be played, by absolute name.
    """

    topics: tuple[str, ...] = ()
    remaps: Mapping[str, str] = field(default_factory=dict)
    start: float = 0.0
    end: float | None = None
    left_out: Mapping[str, str] = field(default_factory=dict)


class ReplaySource:
    """Messages of all files of a log in the order of log time, unchanged.

    Files may be split, truncated, compressed by lz4 or zstd or uncompressed, with messages in any order. Every complete
    chunk of a truncated file is played. The log is read once by the constructor and once by each call of `messages`;
    only messages out of order are held in memory.

    Args:
        path: A rosbag2 folder or an .mcap file.
        choice: Topics, names and times to be played; default: everything.

    Attributes:
        topics: Topics that are played; messages refer to them by their index.
        not_played: Why a topic cannot be played, by name.
        recorded: All topics of the log by name.
        window: Log times that are played [ns].
        warnings: Damage in the files.

    Raises:
        InputError: There is no such log, topic or time, or nothing is left to be played.
    """

    def __init__(self, path: Path | str, choice: ReplayChoice | None = None) -> None:
        self.path = Path(path)
        choice = choice or ReplayChoice()
        bag = find_bag_files(self.path)
        self._surveys = [survey_file(file) for file in bag.files]
        self.warnings = (*bag.warnings, *(text for survey in self._surveys for text in survey.warnings))
        self.recorded, conflicts = _merged(self._surveys)
        self.window = self._window(choice)
        chosen = [topic for topic in self._chosen(choice.topics) if topic.count]
        refusals = {topic.name: topic.refusal for topic in chosen}
        refusals |= {name: why for name, why in (conflicts | dict(choice.left_out)).items() if name in refusals}
        self.not_played = {name: why for name, why in refusals.items() if why}
        self.topics = self._named([topic for topic in chosen if not refusals[topic.name]], choice)
        self._check_something_is_left()

    def _window(self, choice: ReplayChoice) -> TimeWindow:
        first = min((time for survey in self._surveys for time in survey.earliest), default=-1)
        last = max(survey.latest for survey in self._surveys)
        if last < 0:
            hints = "".join(f"; {text}" for text in self.warnings)
            raise InputError(f"{self.path} holds no messages{hints}; give a log with messages")
        length = (last - first) / NANOSECONDS
        if choice.start > length:
            raise InputError(f"the replay is to begin at {choice.start:g} s, but {self.path} lasts only {length:g} s")
        end = length if choice.end is None else choice.end
        if not (math.isfinite(choice.start) and math.isfinite(end) and 0 <= choice.start <= end):
            raise InputError(
                f"the replay of {self.path} is to go from {choice.start:g} s to {end:g} s, but must begin at 0 s or "
                f"later and end after that; the log lasts {length:g} s"
            )
        until = last if choice.end is None else min(last, first + round(end * NANOSECONDS))
        return TimeWindow(first + round(choice.start * NANOSECONDS), until)

    def _chosen(self, names: Iterable[str]) -> list[RecordedTopic]:
        chosen = [self._known(name) for name in names]
        return [self.recorded[name] for name in dict.fromkeys(chosen)] if chosen else list(self.recorded.values())

    def _known(self, name: str) -> str:
        if (full := absolute_name(name)) not in self.recorded:
            raise unknown_name("topic", name, self.recorded, str(self.path))
        return full

    def _named(self, topics: list[RecordedTopic], choice: ReplayChoice) -> tuple[PlayedTopic, ...]:
        names = {self._known(name): absolute_name(new) for name, new in choice.remaps.items()}
        known = {topic.name for topic in topics} | set(self.not_played)
        for name, new in names.items():
            if name not in known:
                raise InputError(f"topic {name} is renamed, but it is not among those to be played; choose it, too")
            if problem := name_problem(new):
                raise InputError(f"topic {name} cannot be renamed: {problem}")
        played = tuple(PlayedTopic(topic, names.get(topic.name, topic.name)) for topic in topics)
        taken: dict[str, str] = {}
        for topic in played:
            if topic.name in taken:
                raise InputError(
                    f"topics {taken[topic.name]} and {topic.recorded.name} would both be played as {topic.name}; "
                    "give one of them another name"
                )
            taken[topic.name] = topic.recorded.name
        return played

    def _check_something_is_left(self) -> None:
        if not self.topics:
            why = "; ".join(f"{name}: {reason}" for name, reason in self.not_played.items())
            raise InputError(f"no topic of {self.path} can be played: {why or 'those chosen have no messages'}")
        if next(self.messages(), None) is None:
            first, last = ((time - self.beginning) / NANOSECONDS for time in self.window)
            raise InputError(
                f"{self.path} has no messages of the topics chosen from {first:g} s to {last:g} s; choose another time"
            )

    @property
    def beginning(self) -> int:
        """Earliest log time of the log, from which `start` and `end` count [ns]."""
        return min(time for survey in self._surveys for time in survey.earliest)

    @property
    def duration(self) -> float:
        """Time that is played [s]."""
        return (self.window.last - self.window.first) / NANOSECONDS

    def messages(self) -> Iterator[ReplayMessage]:
        """Return the messages in the order of log time; messages of equal time keep their order in the files."""
        number = {topic.recorded.name: i for i, topic in enumerate(self.topics)}
        streams = []
        for survey in self._surveys:
            selected = {
                channel: number[topic.name]
                for channel, topic in survey.channels.items()
                if topic.name in number and topic.type == self.recorded[topic.name].type and not topic.refusal
            }
            if selected and survey.latest >= self.window.first and min(survey.earliest) <= self.window.last:
                streams.append(file_messages(survey, selected, self.window))
        return heapq.merge(*streams, key=attrgetter("log_time"))


def _merged(surveys: Iterable[FileSurvey]) -> tuple[dict[str, RecordedTopic], dict[str, str]]:
    """Merge the topics of all files; return them, and why some cannot be played."""
    topics: dict[str, RecordedTopic] = {}
    conflicts: dict[str, str] = {}
    for survey in surveys:
        for topic in survey.channels.values():
            known = topics.get(topic.name)
            if known is None:
                topics[topic.name] = topic
            elif known.type != topic.type:
                conflicts[topic.name] = f"it is recorded as {known.type} and as {topic.type}"
            else:
                topics[topic.name] = known.with_messages(topic.count, topic.largest)
    return dict(sorted(topics.items())), conflicts


def read_remaps(text: str) -> dict[str, str]:
    """Read new names of topics.

    Args:
        text: "old:=new", separated by commas.

    Returns:
        New name by name.

    Raises:
        InputError: The text has another form, or names a topic twice.
    """
    remaps: dict[str, str] = {}
    for part in filter(None, map(str.strip, text.split(","))):
        old, is_remap, new = (word.strip() for word in part.partition(":="))
        if not (old and is_remap and new):
            raise InputError(f"a topic is renamed by '{part}', but must be by old:=new, e.g. joint_states:=measured")
        if old in remaps:
            raise InputError(f"topic {old} is renamed twice, to {remaps[old]} and to {new}; leave out one of both")
        remaps[old] = new
    return remaps
