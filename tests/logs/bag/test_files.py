from __future__ import annotations

import pytest

from flexros.errors import InputError
from flexros.logs.bag.files import find_bag_files

METADATA = """
rosbag2_bagfile_information:
  version: 9
  storage_identifier: {storage}
  compression_mode: '{mode}'
  relative_file_paths: [{paths}]
"""


def make(folder, storage="mcap", mode="", paths="b.mcap, a.mcap"):
    (folder / "metadata.yaml").write_text(METADATA.format(storage=storage, mode=mode, paths=paths))
    for name in ("a.mcap", "b.mcap", "stray.mcap"):
        (folder / name).touch()
    return folder


def names(bag):
    return [path.name for path in bag.files]


def test_files_in_the_order_of_the_metadata(tmp_path):
    bag = find_bag_files(make(tmp_path))
    assert names(bag) == ["b.mcap", "a.mcap"]
    assert bag.warnings == ()


def test_paths_of_old_bags_are_taken_by_name(tmp_path):
    assert names(find_bag_files(make(tmp_path, paths="some/where/a.mcap"))) == ["a.mcap"]


def test_single_file(tmp_path):
    assert names(find_bag_files(make(tmp_path) / "stray.mcap")) == ["stray.mcap"]


def test_folder_without_metadata(tmp_path):
    make(tmp_path)
    (tmp_path / "metadata.yaml").unlink()
    bag = find_bag_files(tmp_path)
    assert names(bag) == ["a.mcap", "b.mcap", "stray.mcap"]
    assert "has no metadata.yaml; all its message files were read" in bag.warnings[0]


@pytest.mark.parametrize("text", ["", "a: [", "rosbag2_bagfile_information: 3\n", "other: 1\n"])
def test_damaged_metadata(tmp_path, text):
    make(tmp_path)
    (tmp_path / "metadata.yaml").write_text(text)
    bag = find_bag_files(tmp_path)
    assert len(bag.files) == 3
    assert "metadata.yaml cannot be used" in bag.warnings[0]


def test_missing_part_is_named(tmp_path):
    bag = find_bag_files(make(tmp_path, paths="a.mcap, lost.mcap"))
    assert names(bag) == ["a.mcap"]
    assert "lacks lost.mcap, listed in metadata.yaml" in bag.warnings[0]


def test_other_storage_is_refused(tmp_path):
    with pytest.raises(
        InputError, match="has the storage 'my_plugin', allowed are mcap and sqlite3; convert it with 'ros2 bag convert"
    ):
        find_bag_files(make(tmp_path, storage="my_plugin"))


def test_both_storages_are_taken(tmp_path):
    (tmp_path / "c.db3").touch()
    assert names(find_bag_files(make(tmp_path, storage="sqlite3", paths="c.db3"))) == ["c.db3"]
    assert names(find_bag_files(tmp_path / "c.db3")) == ["c.db3"]


@pytest.mark.parametrize("mode", ["FILE", "message"])
def test_compression_around_mcap_is_refused(tmp_path, mode):
    with pytest.raises(InputError, match=f"has the compression mode '{mode}', allowed is compression inside MCAP"):
        find_bag_files(make(tmp_path, mode=mode))


def test_nothing_there(tmp_path):
    with pytest.raises(InputError, match="there is no log at .*; give a rosbag2 folder, an .mcap or a .db3 file"):
        find_bag_files(tmp_path / "x")


def test_folder_without_logs(tmp_path):
    (tmp_path / "notes.txt").touch()
    with pytest.raises(InputError, match=r"has no .mcap or .db3 file \(it holds notes.txt\)"):
        find_bag_files(tmp_path)


def test_other_kind_of_file(tmp_path):
    (tmp_path / "x.bag").touch()
    with pytest.raises(InputError, match="is a '.bag' file, allowed is a rosbag2 folder or an .mcap or .db3 file"):
        find_bag_files(tmp_path / "x.bag")


def test_provenance(tmp_path):
    (make(tmp_path) / "provenance.json").write_text('{"seed": 4}')
    assert find_bag_files(tmp_path).provenance == {"seed": 4}
    assert find_bag_files(tmp_path / "a.mcap").provenance == {"seed": 4}
