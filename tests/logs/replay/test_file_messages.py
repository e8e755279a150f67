"""The messages of one file in the order of time."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from mcap.writer import CompressionType

from flexros.logs.replay.file_messages import TimeWindow, file_messages, survey_file

Write = Callable[..., Path]
ALL = TimeWindow(0, 2**64 - 1)
N = 200


def shuffled(seed: int = 1) -> list[tuple[str, int, str]]:
    """Messages of two topics, out of order over several chunks, two of each time."""
    times = 1_700_000_000_000_000_001 + np.arange(N) // 2
    order = np.random.default_rng(seed).permutation(N)
    return [("ab"[k % 2], int(times[k]), f"{k}") for k in order.tolist()]


def read(path: Path, window: TimeWindow = ALL) -> list[tuple[int, int, bytes]]:
    survey = survey_file(path)
    numbers = {channel: ["/a", "/b"].index(topic.name) for channel, topic in survey.channels.items()}
    return [tuple(message) for message in file_messages(survey, numbers, window)]


@pytest.mark.parametrize("compression", list(CompressionType))
@pytest.mark.parametrize("chunked", [True, False])
def test_any_order_becomes_the_order_of_time(
    tmp_path: Path,
    write_strings: Write,
    string_message: Callable[[str], bytes],
    compression: CompressionType,
    chunked: bool,
) -> None:
    messages = shuffled()
    path = write_strings(tmp_path / "a.mcap", messages, compression=compression, use_chunking=chunked, chunk_size=400)
    expected = [(time, "ab".index(name), string_message(text)) for name, time, text in messages]
    assert read(path) == sorted(expected, key=lambda message: message[0])  # of one time as they stand in the file


def test_a_file_in_order_is_held_back_by_no_more_than_a_chunk(tmp_path: Path, write_strings: Write) -> None:
    path = write_strings(tmp_path / "a.mcap", [("a", k, "x" * 100) for k in range(N)], chunk_size=1000)
    survey = survey_file(path)
    assert len(survey.earliest) > 10
    stream = file_messages(survey, {1: 0}, ALL)
    assert next(stream).log_time == 0
    assert len(stream.gi_frame.f_locals["held"]) < 20  # type: ignore[attr-defined]


def test_both_ends_of_a_window_belong_to_it(tmp_path: Path, write_strings: Write) -> None:
    path = write_strings(tmp_path / "a.mcap", [("a", 10 * k, f"{k}") for k in range(9)], chunk_size=60)
    assert [time for time, _, _ in read(path, TimeWindow(20, 50))] == [20, 30, 40, 50]


def test_a_survey_counts_and_measures(tmp_path: Path, write_strings: Write) -> None:
    survey = survey_file(write_strings(tmp_path / "a.mcap", [("a", 5, "x"), ("b", 9, "longer"), ("b", 7, "y")]))
    assert {topic.name: (topic.count, topic.largest) for topic in survey.channels.values()} == {
        "/a": (1, 10),
        "/b": (2, 15),
    }
    assert (min(survey.earliest), survey.latest) == (5, 9)
    assert survey.warnings == []


def test_of_a_file_that_is_truncated_every_complete_chunk_is_there(tmp_path: Path, write_strings: Write) -> None:
    path = write_strings(tmp_path / "a.mcap", [("a", k, "x" * 100) for k in range(N)], chunk_size=1000, finish=False)
    whole = read(path)
    content = path.read_bytes()
    path.write_bytes(content[: len(content) // 2])
    part = read(path)
    assert 0 < len(part) < len(whole)
    assert part == whole[: len(part)]
    assert "is truncated at byte" in survey_file(path).warnings[0]
