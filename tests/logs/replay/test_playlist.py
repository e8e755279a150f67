"""All that a replay sends."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from flexros.errors import InputError
from flexros.logs.replay.playlist import LARGEST_QUEUE, SMALLEST_QUEUE, Playlist, queue_depth
from flexros.logs.replay.recorded_topic import RecordedTopic
from flexros.logs.replay.source import ReplayChoice
from flexros.logs.write_log import write_log

pytestmark = pytest.mark.slow

Write = Callable[..., Path]
SECOND = 10**9


def names(playlist: Playlist) -> list[str]:
    return [playlist.topics[message.topic].name for message in playlist.messages()]


@pytest.fixture
def own(tmp_path: Path, make_log: Any) -> Path:
    write_log(make_log(400), tmp_path / "own")
    return tmp_path / "own"


def test_the_clock_tells_log_time_before_what_has_the_same_time(own: Path, store: Any) -> None:
    playlist = Playlist(own, ReplayChoice(("joint_states",)), clock_rate=100.0)
    messages = list(playlist.messages())
    clock = [message for message in messages if playlist.topics[message.topic].name == "/clock"]
    assert [message.log_time for message in clock] == [SECOND + k * SECOND // 100 for k in range(20)]
    told = [store.deserialize_cdr(message.payload, "rosgraph_msgs/msg/Clock").clock for message in clock]
    assert [t.sec * SECOND + t.nanosec for t in told] == [message.log_time for message in clock]
    assert messages[0] == clock[0]
    times = [message.log_time for message in messages]
    assert times == sorted(times)


def test_a_controller_is_fed_ahead_and_does_not_hear_recorded_commands(own: Path) -> None:
    playlist = Playlist(own, ReplayChoice(), feeds_controller=True)
    assert playlist.controller is not None
    assert playlist.topics[playlist.controller.states].name == "/joint_states"
    assert playlist.controller.commands == "/joint_commands"
    played = names(playlist)
    assert played[:2] == ["/joint_reference_ahead"] * 2
    assert set(played) == {"/joint_reference_ahead", "/joint_states", "/tool_pose", "/tool_reference"}
    assert playlist.playable(lambda _: "")[1] == {}


def test_recorded_commands_may_be_played_under_another_name(own: Path) -> None:
    choice = ReplayChoice(remaps={"joint_commands": "recorded/commands", "joint_states": "robot/joint_states"})
    playlist = Playlist(own, choice, feeds_controller=True)
    assert playlist.controller is not None
    assert playlist.controller.commands == "/robot/joint_commands"
    assert {"/recorded/commands", "/robot/joint_states", "/robot/joint_reference_ahead"} <= set(names(playlist))


def test_a_controller_needs_measurements(own: Path) -> None:
    with pytest.raises(InputError, match="one topic joint_states is needed, there is none; choose one"):
        Playlist(own, ReplayChoice(("tool_pose",)), feeds_controller=True)


def test_what_cannot_be_published_here_is_left_out_with_a_reason(tmp_path: Path, write_strings: Write) -> None:
    path = write_strings(tmp_path / "a.mcap", [("a", 1, "x"), ("b", 2, "y"), ("c d", 3, "z")])
    playlist = Playlist(path, ReplayChoice(), clock_rate=1.0)
    left, left_out = playlist.playable(lambda topic: "no such package" if topic.name == "/a" else "")
    assert [topic.name for topic in left.values()] == ["/b", "/clock"]
    assert left_out["/a"] == "no such package"
    assert left_out["/c d"].startswith("'/c d' is not a topic name")
    with pytest.raises(InputError, match="no topic of .* can be played here: /a: none; /b: none"):
        playlist.playable(lambda topic: "" if topic.name == "/clock" else "none")


@pytest.mark.parametrize(("largest", "depth"), [(0, LARGEST_QUEUE), (260, LARGEST_QUEUE), (10**8, SMALLEST_QUEUE)])
def test_fewer_large_messages_are_kept(largest: int, depth: int) -> None:
    assert queue_depth(RecordedTopic("/a", "std_msgs/msg/String", largest=largest)) == depth
