"""Folders that clean removes, and those that it keeps."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from flexros.installation.leftovers import RECENT, find_leftovers, remove


@pytest.fixture
def temporary(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a folder of temporary files with one of ours, one of others, a file and a link."""
    monkeypatch.setenv("FLEXROS_CACHE", "off")
    folder = tmp_path / "tmp"
    (folder / "flexros_ab" / "below").mkdir(parents=True)
    (folder / "flexros_ab" / "below" / "log.mcap").write_bytes(bytes(300))
    (folder / "others_ab").mkdir()
    (folder / "flexros_file").write_text("")
    (folder / "flexros_link").symlink_to(folder / "others_ab")
    return folder


def test_only_own_folders_are_found(temporary: Path, tmp_path: Path) -> None:
    (found,) = find_leftovers(temporary, tmp_path / "no_proc", time.time() + 2 * RECENT)
    assert (found.path.name, found.size, found.files, found.in_use) == ("flexros_ab", 300, 1, False)
    assert remove([found]) == (found,)
    assert not found.path.exists()


def test_recent_folders_are_in_use(temporary: Path, tmp_path: Path) -> None:
    (found,) = find_leftovers(temporary, tmp_path / "no_proc")
    assert found.in_use
    assert remove([found]) == ()
    assert found.path.exists()


def test_folders_of_a_process_are_in_use(temporary: Path, tmp_path: Path) -> None:
    process = tmp_path / "proc" / "123"
    process.mkdir(parents=True)
    (process / "environ").write_text(f"A=1\0ROS_LOG_DIR={temporary / 'flexros_ab'}\0")
    (found,) = find_leftovers(temporary, tmp_path / "proc", time.time() + 2 * RECENT)
    assert found.in_use


def test_cache_of_compiled_models_is_found(temporary: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FLEXROS_CACHE", str(tmp_path / "cache"))
    objects = tmp_path / "cache" / "objects"
    objects.mkdir(mode=0o700, parents=True)
    (objects / "a.o").write_bytes(bytes(10))
    cache = find_leftovers(temporary, tmp_path / "no_proc")[0]
    assert (cache.path, cache.size, cache.in_use) == (objects, 10, False)
