"""Shared memory segments of killed processes."""

from __future__ import annotations

import fcntl
import threading
from pathlib import Path

import pytest

from flexros_nodes.shell.shared_memory import remove_segments_without_owner

SEGMENT = "fastrtps_93653a9b76ea31e0"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    folder = tmp_path / "shm"
    folder.mkdir()
    for name in (SEGMENT, f"{SEGMENT}_el", "fastrtps_port7413", "sem.fastrtps_port7413_mutex", "other_data"):
        (folder / name).write_text("")
    return folder


@pytest.fixture
def processes(tmp_path: Path) -> Path:
    process = tmp_path / "proc" / "77"
    process.mkdir(parents=True)
    (process / "maps").write_text("7fcb-7fcc r--p 00000000 00:17 12 /usr/lib/libc.so\n")
    return process.parent


def test_unused_segments_are_removed(folder: Path, processes: Path) -> None:
    assert remove_segments_without_owner(folder, processes) == [SEGMENT, "fastrtps_port7413"]
    assert [path.name for path in folder.iterdir()] == ["other_data"]


def test_locked_segment_stays(folder: Path, processes: Path) -> None:
    with (folder / f"{SEGMENT}_el").open("rb") as owner:
        fcntl.flock(owner, fcntl.LOCK_EX)
        assert remove_segments_without_owner(folder, processes) == ["fastrtps_port7413"]
    assert (folder / SEGMENT).exists()


def test_segment_whose_lock_another_cleaner_tries_just_now_is_removed(folder: Path, processes: Path) -> None:
    with (folder / f"{SEGMENT}_el").open("rb") as cleaner:
        fcntl.flock(cleaner, fcntl.LOCK_EX)
        release = threading.Timer(0.07, fcntl.flock, (cleaner, fcntl.LOCK_UN))
        release.start()
        assert remove_segments_without_owner(folder, processes) == ["fastrtps_port7413", SEGMENT]
        release.join()
    assert [path.name for path in folder.iterdir()] == ["other_data"]


def test_mapped_segment_stays(folder: Path, processes: Path) -> None:
    line = f"7fcb-7fcc rw-s 00000000 00:17 12    {folder}/fastrtps_port7413\n"
    (processes / "77" / "maps").write_text(line)
    assert remove_segments_without_owner(folder, processes) == [SEGMENT]
    assert (folder / "sem.fastrtps_port7413_mutex").exists()


def test_system_without_shared_memory_has_nothing_to_remove(tmp_path: Path) -> None:
    assert remove_segments_without_owner(tmp_path / "nowhere") == []
