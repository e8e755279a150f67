"""Folders that clean removes, and those that it keeps."""

from __future__ import annotations

import re
import tempfile
import time
from pathlib import Path

import pytest

import flexros
import flexros_nodes
from flexros.installation.leftovers import RECENT, TEMPORARY, find_leftovers, remove


@pytest.fixture
def temporary(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a folder of temporary files with one of ours, one of others, a file and a link."""
    monkeypatch.setenv("FLEXROS_CACHE", "off")
    folder = tmp_path / "tmp"
    (folder / "flexros_ab12cd34" / "below").mkdir(parents=True)
    (folder / "flexros_ab12cd34").chmod(0o700)
    (folder / "flexros_ab12cd34" / "below" / "log.mcap").write_bytes(bytes(300))
    (folder / "others_ab").mkdir()
    (folder / "flexros_file").write_text("")
    (folder / "flexros_link").symlink_to(folder / "others_ab")
    return folder


def test_only_own_folders_are_found(temporary: Path, tmp_path: Path) -> None:
    (found,) = find_leftovers(temporary, tmp_path / "no_proc", time.time() + 2 * RECENT)
    assert (found.path.name, found.size, found.files, found.in_use) == ("flexros_ab12cd34", 300, 1, False)
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
    (process / "environ").write_text(f"A=1\0ROS_LOG_DIR={temporary / 'flexros_ab12cd34'}\0")
    (found,) = find_leftovers(temporary, tmp_path / "proc", time.time() + 2 * RECENT)
    assert found.in_use


def test_cache_of_compiled_models_is_found(temporary: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FLEXROS_CACHE", str(tmp_path / "cache"))
    objects = tmp_path / "cache" / "objects"
    objects.mkdir(mode=0o700, parents=True)
    (objects / "a.o").write_bytes(bytes(10))
    cache = find_leftovers(temporary, tmp_path / "no_proc")[0]
    assert (cache.path, cache.size, cache.in_use) == (objects, 10, False)


@pytest.mark.parametrize("name", ["flexros_circle", "flexros_my_results", "flexros_circle_d"])
def test_results_among_the_temporary_files_are_kept(temporary: Path, tmp_path: Path, name: str) -> None:
    """`flexros run ... --out /tmp/flexros_circle` is a result, whatever its age."""
    (temporary / name).mkdir(mode=0o755)
    (temporary / name).chmod(0o755)
    (found,) = find_leftovers(temporary, tmp_path / "no_proc", time.time() + 2 * RECENT)
    assert found.path.name == "flexros_ab12cd34"


@pytest.mark.parametrize("prefix", ["flexros_", "flexros_logs_", "flexros_truth_", "flexros_launch_"])
def test_folders_of_tempfile_are_found(temporary: Path, tmp_path: Path, prefix: str) -> None:
    made = Path(tempfile.mkdtemp(prefix=prefix, dir=temporary))
    found = find_leftovers(temporary, tmp_path / "no_proc", time.time() + 2 * RECENT)
    assert made in {one.path for one in found}


def test_every_prefix_of_the_project_is_known() -> None:
    rooms = [Path(flexros.__file__).parent, Path(flexros_nodes.__file__).parent]
    texts = "".join(path.read_text() for room in rooms for path in room.rglob("*.py"))
    prefixes = set(re.findall(r'prefix="(flexros_\w*)"', texts))
    assert {"flexros_", "flexros_logs_"} <= prefixes
    assert all(TEMPORARY.fullmatch(f"{prefix}ab12cd34") for prefix in prefixes), prefixes
