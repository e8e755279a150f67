"""Replay node: publishes the messages of a log again."""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING

from rclpy.duration import Duration
from sensor_msgs.msg import JointState

from flexros.errors import FlexrosError, InputError
from flexros.logs.replay.pace import ReplayPace
from flexros.logs.replay.playlist import LATEST_STAMP, Playlist
from flexros.logs.replay.source import ReplayChoice, read_remaps
from flexros.logs.stamps import NANOSECONDS
from flexros_nodes.protocol.controller_answers import ControllerAnswers
from flexros_nodes.shell.claims import PRODUCERS
from flexros_nodes.shell.executable import run_node
from flexros_nodes.shell.node_base import FlexrosNode
from flexros_nodes.shell.raw_topic import MissingTypeError, installed_class, played_qos
from flexros_nodes.shell.topic_interface import qos_profile, topic
from flexros_nodes.shell.topic_node import Answer

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rclpy.publisher import Publisher

    from flexros.logs.replay.file_messages import ReplayMessage
    from flexros.logs.replay.source import PlayedTopic
    from flexros_nodes.protocol.parameters import Value

PLAY_PERIOD = 5e-4
"""Period at which due messages are published [s], chosen: it limits the usual delay of a message."""

SLICE = 5e-3
"""Longest time of publishing without serving other callbacks [s], chosen."""

FLUSH_TIMEOUT = 1.0
"""Longest wait at the end for acknowledgements of the subscribers [s], chosen."""

DIAGNOSTICS_PERIOD = 1.0
"""Period of the diagnostics [s]."""


class ReplayNode(FlexrosNode):
    """Replay of a log: raw messages in the order of log time, unchanged including header stamps."""

    node_name = "replay"
    playlist: Playlist | None = None
    warnings: Sequence[str] = ()

    def configure(self) -> None:
        """Scan the log, create a publisher for each playable topic, offer pause and resume."""
        if not self.value("bag"):
            raise InputError("parameter bag of node replay is empty; give a rosbag2 folder or an .mcap file")
        self.playlist = playlist = Playlist(
            Path(self.value("bag")),
            self._choice(),
            clock_rate=self.value("clock_rate"),
            feeds_controller=self.value("feed_controller"),
        )
        if playlist.controller is not None and self.value("loop"):
            raise InputError(
                "feed_controller and loop are both true, but a controller accepts no stamp twice; set one to false"
            )
        self._pace = ReplayPace(self._rate())
        self._answers: ControllerAnswers | None = None
        self._outlets, left_out = self._announced(playlist)
        not_played = [f"topic {name} is not played: {why}" for name, why in left_out.items()]
        self.warnings = [*playlist.source.warnings, *not_played]
        if playlist.controller is not None:
            self._listen_to_commands(playlist.controller.commands)
        self.offer("pause", self._pause)
        self.offer("resume", self._resume)
        for warning in self.warnings if self.tells_errors else ():
            self.get_logger().warning(warning)
        self._begin()

    def _choice(self) -> ReplayChoice:
        end = self.value("to_time")
        return ReplayChoice(
            topics=tuple(filter(None, map(str.strip, self.value("topics").split(",")))),
            remaps=read_remaps(self.value("remaps")),
            start=self.value("from_time"),
            end=end if end < 1e9 else None,
        )

    def _rate(self) -> float:
        return math.inf if self.value("as_fast_as_possible") else float(self.value("rate"))

    def _announced(self, playlist: Playlist) -> tuple[dict[int, Publisher], dict[str, str]]:
        """Create the publishers, and return the reasons for topics that cannot be published."""
        types: dict[str, type] = {}

        def problem(topic: PlayedTopic) -> str:
            try:
                types[topic.recorded.type] = installed_class(topic.recorded.type)
            except MissingTypeError as why:
                return str(why)
            return ""

        played, left_out = playlist.playable(problem)
        publishers = {}
        for number, row in played.items():
            publisher = self.create_publisher(types[row.recorded.type], row.name, played_qos(row.recorded))
            self.on_close(partial(self.destroy_publisher, publisher))
            publishers[number] = publisher
        names = {publisher.topic_name for publisher in publishers.values()}
        for name in PRODUCERS:
            if self.resolve_topic_name(name) in names:
                self.claim(name)
        return publishers, left_out

    def _listen_to_commands(self, commands: str) -> None:
        """Subscribe to the commands of the fed controller."""
        profile = qos_profile(topic("joint_commands").subscription_qos)
        subscription = self.create_subscription(JointState, commands, self._on_command, profile, raw=True)
        self.on_close(partial(self.destroy_subscription, subscription))

    def _begin(self) -> None:
        """Return to the state before the first message."""
        playlist = self._configured_playlist()
        self._counts = dict.fromkeys(self._outlets, 0)
        self._turns, self._latest = 0, 0.0
        self._messages = playlist.messages()
        self._next = next(self._messages, None)
        if playlist.controller is not None:
            self._answers = ControllerAnswers(playlist.controller.feed, self.value("answer_timeout"))

    def _configured_playlist(self) -> Playlist:
        if self.playlist is None:
            raise InputError("the replay is not configured; configure it first")
        return self.playlist

    def start(self) -> None:
        """Start playing, always from the beginning."""
        self._begin()
        self._pace = ReplayPace(self._rate())
        self._pace.begin(perf_counter() + self.value("start_delay"), self._configured_playlist().source.window.first)
        if self.value("paused"):
            self._pace.pause(perf_counter())
        self.every(PLAY_PERIOD, self._play)
        self.every(DIAGNOSTICS_PERIOD, self.diagnose)

    def parameters_changed(self, values: Mapping[str, Value]) -> None:
        """Apply a changed rate."""
        if "rate" in values and not self.value("as_fast_as_possible"):
            self._pace.change_rate(float(values["rate"]), perf_counter())

    # Playing.

    def _play(self) -> None:
        """Publish the messages that are due."""
        stop = perf_counter() + SLICE
        while self._next is not None and not (self._awaits_command() and self._is_held(self._next)):
            now = perf_counter()
            if (due := self._pace.due(self._next.log_time)) > now or now > stop:
                return
            self._latest = max(self._latest, now - due)
            self._send(self._next, now)
            self._next = next(self._messages, None)
        if self._next is None and not self._awaits_command():
            self._end_turn()

    def _is_held(self, message: ReplayMessage) -> bool:
        """Return whether a message waits for the command of the measurement before: the next measurement."""
        controller = self._configured_playlist().controller
        return controller is not None and message.topic == controller.states

    def _send(self, message: ReplayMessage, now: float) -> None:
        if (publisher := self._outlets.get(message.topic)) is None:
            return
        publisher.publish(message.payload)
        self.stamp = min(message.log_time, LATEST_STAMP)
        self._counts[message.topic] += 1
        controller = self._configured_playlist().controller
        if controller is None or self._answers is None:
            return
        if message.topic == controller.states:
            self._answers.sent_state(message.payload, now)
        elif message.topic == controller.chunks:
            self._answers.sent_chunk()
        elif message.topic in controller.sensors:
            self._answers.sent_sensor(message.topic, message.payload)

    def _end_turn(self) -> None:
        self._turns += 1
        if self.value("loop"):
            playlist = self._configured_playlist()
            self._messages = playlist.messages()
            self._next = next(self._messages, None)
            self._pace.begin(perf_counter(), playlist.source.window.first)
            return
        patience = perf_counter() + FLUSH_TIMEOUT
        for publisher in self._outlets.values():
            publisher.wait_for_all_acked(Duration(seconds=max(patience - perf_counter(), 0.0)))
        self.end()

    # The fed controller.

    def _awaits_command(self) -> bool:
        """Return whether a command is awaited; repeat the measurement when it is overdue."""
        if self._answers is None or not self._answers.waits:
            return False
        controller = self._configured_playlist().controller
        state, chunks = self._answers.to_repeat(perf_counter())
        if state and controller is not None:
            for chunk in chunks:
                self._outlets[controller.chunks].publish(chunk)
            for index, payload in self._answers.sensors_to_repeat:
                self._outlets[index].publish(payload)
            self._outlets[controller.states].publish(state)
        return True

    def _on_command(self, message: bytes) -> None:
        if self.active and self._answers is not None:
            try:
                if self._answers.add_command(message):
                    self._play()
            except FlexrosError as error:
                self.end(error)

    # Services and figures.

    def _pause(self) -> Answer:
        self._pace.pause(perf_counter())
        return Answer(True, f"paused at {self.position:.3f} s")

    def _resume(self) -> Answer:
        self._pace.resume(perf_counter())
        return Answer(True, f"playing from {self.position:.3f} s on")

    @property
    def position(self) -> float:
        """Log time of the newest message since the start of the played window [s]."""
        return max(self.stamp - self._configured_playlist().source.window.first, 0) / NANOSECONDS

    @property
    def duration(self) -> float:
        """Duration of the played window [s]."""
        return self._configured_playlist().source.duration

    def figures(self) -> dict[str, float]:
        """Return counts of messages, the largest delay, and the answers of a fed controller."""
        topics = self._configured_playlist().topics
        figures: dict[str, float] = {"messages": sum(self._counts.values()), "turns": self._turns}
        if math.isfinite(self._rate()):
            figures["latest_ms"] = 1e3 * self._latest
        figures |= {f"{topics[i].name}.messages": count for i, count in self._counts.items()}
        if (answers := self._answers) is not None:
            figures |= {
                "equal_commands": answers.equal,
                "different_commands": answers.different,
                "commands_without_record": answers.unknown,
                "measurements_repeated": answers.repeats,
            }
        return figures


def main() -> int:
    """Run the node in this process."""
    return run_node(ReplayNode)


if __name__ == "__main__":
    raise SystemExit(main())
