"""Reading text files of limited size."""

from __future__ import annotations

from pathlib import Path

import pytest

from flexros.config.text_file import is_file, read_json, read_text
from flexros.errors import InputError
from flexros.input_limits import LARGEST_TEXT


def test_text_up_to_the_limit_is_read(tmp_path: Path) -> None:
    file = tmp_path / "a.txt"
    file.write_text("x" * LARGEST_TEXT)
    assert len(read_text(file, "YAML")) == LARGEST_TEXT


def test_larger_file_is_refused_without_reading_it(tmp_path: Path) -> None:
    file = tmp_path / "a.txt"
    with file.open("wb") as stream:
        stream.truncate(2**40)
    with pytest.raises(InputError, match=r"a\.txt is larger than the 1048576 bytes that are allowed for a YAML file"):
        read_text(file, "YAML")


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("gone.txt", None, r"cannot read .*gone\.txt: No such file or directory; give the path of a readable URDF"),
        ("a\0b.txt", None, r"cannot read .*a\\x00b\.txt: embedded null byte"),
        ("a.txt", b"ab\xff", r"a\.txt is not a text file \(byte 2 is not UTF-8\); give a URDF file"),
    ],
)
def test_unreadable_file_is_named(tmp_path: Path, name: str, content: bytes | None, message: str) -> None:
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError, match=message):
        read_text(tmp_path / name, "URDF")


@pytest.mark.parametrize("name", ["x" * 3000, "a\0b", "gone"])
def test_there_is_no_file_of_an_impossible_name(tmp_path: Path, name: str) -> None:
    assert not is_file(tmp_path / name)


def test_json_is_read(tmp_path: Path) -> None:
    (tmp_path / "a.json").write_text('{"a": [1, 2.5]}')
    assert read_json(tmp_path / "a.json") == {"a": [1, 2.5]}


@pytest.mark.parametrize("content", ["", "{", "[" * 10**5, "1" * 5000])
def test_broken_json_is_named(tmp_path: Path, content: str) -> None:
    (tmp_path / "a.json").write_text(content)
    with pytest.raises(InputError, match=r"a\.json is not JSON \("):
        read_json(tmp_path / "a.json")
