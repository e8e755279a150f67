"""Files that are there whole or not at all."""

from __future__ import annotations

from pathlib import Path

import pytest

from flexros.atomic_file import write_result, write_whole
from flexros.errors import InputError


def test_file_is_written_and_nothing_else_left(tmp_path: Path) -> None:
    write_whole(tmp_path / "a.txt", "ü")
    assert (tmp_path / "a.txt").read_text(encoding="utf-8") == "ü"
    assert [path.name for path in tmp_path.iterdir()] == ["a.txt"]


def test_bytes_are_written_as_they_are(tmp_path: Path) -> None:
    write_whole(tmp_path / "a.bin", b"\r\n\xff\x00")
    write_result(tmp_path / "b.bin", b"\x00\xff", "result")
    assert (tmp_path / "a.bin").read_bytes() == b"\r\n\xff\x00"
    assert (tmp_path / "b.bin").read_bytes() == b"\x00\xff"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.bin", "b.bin"]


def test_old_file_is_kept_when_writing_fails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "a.txt"
    file.write_text("old")

    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "replace", full)
    with pytest.raises(OSError, match="No space left"):
        write_whole(file, "new")
    assert file.read_text() == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["a.txt"]


def test_interrupted_writing_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(Path, "replace", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_whole(tmp_path / "a.txt", "new")
    assert list(tmp_path.iterdir()) == []


def test_writers_of_the_same_file_do_not_mix(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file, replace = tmp_path / "a.txt", Path.replace

    def late(temporary: Path, target: Path) -> Path:
        monkeypatch.setattr(Path, "replace", replace)
        write_whole(file, "of another writer")
        return replace(temporary, target)

    monkeypatch.setattr(Path, "replace", late)
    write_whole(file, "own")
    assert file.read_text() == "own"
    assert [path.name for path in tmp_path.iterdir()] == ["a.txt"]


def test_text_that_utf_8_does_not_have_is_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"the report cannot be written to .*: it holds '\\udcff', which is no char"):
        write_result(tmp_path / "a.html", "log \udcff", "report")
    assert list(tmp_path.iterdir()) == []


def test_missing_folder_is_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="the report cannot be written to .*its folder must exist"):
        write_result(tmp_path / "none" / "a.html", "x", "report")


def test_a_folder_is_no_file() -> None:
    with pytest.raises(InputError, match=r"the report cannot be written to '\.', which is a folder; give a file"):
        write_result(Path(), "x", "report")
