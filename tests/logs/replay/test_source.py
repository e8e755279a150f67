"""A log, own or foreign, whole or split, as one stream of messages."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.writer import CompressionType
from rosbags.rosbag2 import StoragePlugin, Writer

from flexros.errors import InputError
from flexros.logs.replay.source import ReplayChoice, ReplaySource, read_remaps
from flexros.logs.write_log import write_log

Write = Callable[..., Path]
SECOND = 10**9
MESSAGES = [(name, 100 * SECOND + k * SECOND // 10, f"{k}") for k in range(11) for name in ("a", "robot/b")]


def told(source: ReplaySource) -> list[tuple[str, int, bytes]]:
    return [(source.topics[m.topic].name, m.log_time, m.payload) for m in source.messages()]


@pytest.fixture
def log(tmp_path: Path, write_strings: Write) -> Path:
    return write_strings(tmp_path / "a.mcap", MESSAGES, chunk_size=200)


def test_split_files_of_any_compression_are_one_stream(
    tmp_path: Path, write_strings: Write, string_message: Callable[[str], bytes]
) -> None:
    folder = tmp_path / "split"
    folder.mkdir()
    for i, compression in enumerate(CompressionType):
        write_strings(folder / f"split_{i}.mcap", MESSAGES[i :: len(CompressionType)], compression=compression)
    source = ReplaySource(folder)
    messages = told(source)
    assert sorted(messages) == sorted(("/" + name, time, string_message(text)) for name, time, text in MESSAGES)
    assert [time for _, time, _ in messages] == [time for _, time, _ in MESSAGES]
    assert told(source) == told(source)  # as often as wanted
    assert source.duration == pytest.approx(1.0)
    assert [text for text in source.warnings if "has no metadata.yaml" in text]


def test_an_own_log_is_played_with_every_message(tmp_path: Path, make_log: Any) -> None:
    log = make_log(400)
    write_log(log, tmp_path / "own")
    source = ReplaySource(tmp_path / "own")
    messages = list(source.messages())
    assert len(messages) == 5 * 400
    assert np.all(np.diff([message.log_time for message in messages]) >= 0)
    assert source.not_played == {}
    assert source.warnings == ()


def test_a_log_of_rosbags_with_foreign_types(tmp_path: Path, store: Any) -> None:
    with Writer(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        flag = writer.add_connection("/flag", "std_msgs/msg/Bool", typestore=store)
        tree = writer.add_connection("/tf", "tf2_msgs/msg/TFMessage", typestore=store)
        for k in range(3):
            message = store.types["std_msgs/msg/Bool"](bool(k % 2))
            writer.write(flag, k, store.serialize_cdr(message, "std_msgs/msg/Bool"))
            message = store.types["tf2_msgs/msg/TFMessage"]([])
            writer.write(tree, k, store.serialize_cdr(message, "tf2_msgs/msg/TFMessage"))
    source = ReplaySource(tmp_path / "bag")
    assert {topic.name: topic.recorded.type for topic in source.topics} == {
        "/flag": "std_msgs/msg/Bool",
        "/tf": "tf2_msgs/msg/TFMessage",
    }
    flags = [store.deserialize_cdr(p, "std_msgs/msg/Bool").data for name, _, p in told(source) if name == "/flag"]
    assert flags == [False, True, False]


def test_a_window_counts_from_the_beginning_of_the_log(log: Path) -> None:
    source = ReplaySource(log, ReplayChoice(("a",), start=0.25, end=0.5))
    assert [time for _, time, _ in told(source)] == [100 * SECOND + k * SECOND // 10 for k in (3, 4, 5)]
    assert source.duration == pytest.approx(0.25)


def test_topics_are_chosen_and_renamed(log: Path) -> None:
    source = ReplaySource(log, ReplayChoice(("robot/b",), {"/robot/b": "other/c"}))
    assert {name for name, _, _ in told(source)} == {"/other/c"}
    swapped = ReplaySource(log, ReplayChoice(remaps={"a": "robot/b", "robot/b": "a"}))
    assert [name for name, _, _ in told(swapped)][:2] == ["/robot/b", "/a"]


@pytest.mark.parametrize(
    ("choice", "sentence"),
    [
        (ReplayChoice(("c",)), "unknown topic 'c' in .*allowed are /a, /robot/b"),
        (ReplayChoice(remaps={"c": "d"}), "unknown topic 'c'"),
        (ReplayChoice(("a",), {"robot/b": "d"}), "topic /robot/b is renamed, but it is not among those to be played"),
        (ReplayChoice(remaps={"a": "x y"}), "topic /a cannot be renamed: '/x y' is not a topic name"),
        (ReplayChoice(remaps={"a": "robot/b"}), "topics /a and /robot/b would both be played as /robot/b"),
        (ReplayChoice(start=0.6, end=0.5), "is to go from 0.6 s to 0.5 s, but must begin at 0 s or later"),
        (ReplayChoice(start=-1.0), "must begin at 0 s or later and end after that; the log lasts 1 s"),
        (ReplayChoice(start=float("nan")), "must begin at 0 s or later"),
        (ReplayChoice(start=2.0), "is to begin at 2 s, but .* lasts only 1 s"),
        (ReplayChoice(start=0.51, end=0.59), "has no messages of the topics chosen from 0.51 s to 0.59 s"),
        (ReplayChoice(("a",), left_out={"/a": "why not"}), "no topic of .* can be played: /a: why not"),
    ],
)
def test_bad_choices_are_one_sentence(log: Path, choice: ReplayChoice, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        ReplaySource(log, choice)


def test_an_empty_log_is_refused(tmp_path: Path, write_strings: Write) -> None:
    with pytest.raises(InputError, match=r"a.mcap holds no messages; give a log with messages"):
        ReplaySource(write_strings(tmp_path / "a.mcap", []))


def test_a_log_that_is_truncated_is_played_up_to_there_with_a_warning(log: Path) -> None:
    whole, content = told(ReplaySource(log)), log.read_bytes()
    log.write_bytes(content[: content.index(b"5") + 40])
    source = ReplaySource(log)
    part = told(source)
    assert 0 < len(part) < len(whole)
    assert part == whole[: len(part)]
    assert "is truncated at byte" in source.warnings[0] or "has no end record" in source.warnings[0]


def test_a_topic_of_two_types_is_not_played(tmp_path: Path, write_strings: Write, store: Any) -> None:
    folder = tmp_path / "bag"
    with Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        connection = writer.add_connection("/a", "std_msgs/msg/Bool", typestore=store)
        message = store.types["std_msgs/msg/Bool"](True)
        writer.write(connection, 100 * SECOND, store.serialize_cdr(message, "std_msgs/msg/Bool"))
    write_strings(folder / "more.mcap", MESSAGES)
    (folder / "metadata.yaml").unlink()
    source = ReplaySource(folder)
    assert [topic.name for topic in source.topics] == ["/robot/b"]
    assert source.not_played == {"/a": "it is recorded as std_msgs/msg/Bool and as std_msgs/msg/String"}


def test_new_names_are_read() -> None:
    assert read_remaps(" a:=b, /c := d/e ,") == {"a": "b", "/c": "d/e"}
    assert read_remaps("") == {}


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("a=b", "a topic is renamed by 'a=b', but must be by old:=new"),
        (":=b", "must be by old:=new"),
        ("a:=b,a:=c", "topic a is renamed twice, to b and to c"),
    ],
)
def test_bad_new_names_are_one_sentence(text: str, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        read_remaps(text)


@pytest.mark.slow
def test_a_log_cut_at_any_byte_gives_a_beginning_of_itself(log: Path) -> None:
    whole, content = told(ReplaySource(log)), log.read_bytes()
    lengths = set()
    for end in range(0, len(content), 11):
        log.write_bytes(content[:end])
        try:
            part = told(ReplaySource(log))
        except InputError:
            part = []
        assert part == whole[: len(part)]
        lengths.add(len(part))
    assert len(lengths) > 4


@pytest.mark.slow
def test_damaged_bytes_are_a_warning_or_one_sentence(log: Path) -> None:
    rng, content = np.random.default_rng(1), log.read_bytes()
    played = refused = 0
    for _ in range(150):
        damaged = bytearray(content)
        for place in rng.integers(0, len(content), 4).tolist():
            damaged[place] = int(rng.integers(0, 256))
        log.write_bytes(damaged)
        try:
            source = ReplaySource(log)
        except InputError:
            refused += 1
            continue
        assert all(0 <= message.topic < len(source.topics) for message in source.messages())
        played += 1
    assert played
    assert refused
