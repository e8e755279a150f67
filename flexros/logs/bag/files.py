"""The message files of a log, in MCAP or SQLite storage, and the other files in its folder."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any

from flexros.config.text_file import is_file
from flexros.config.yaml_file import read_yaml
from flexros.errors import InputError
from flexros.input_limits import MOST_WARNINGS
from flexros.logs.bag.metadata import METADATA_FILE
from flexros.logs.provenance_file import read_provenance
from flexros.logs.sqlite.file_reader import STORAGE, SUFFIX

STORAGES = {"mcap": ".mcap", STORAGE: SUFFIX}
"""Suffixes of the files by storage."""


@dataclass(frozen=True)
class BagFiles:
    """A log on disk.

    Attributes:
        files: Its message files in order.
        provenance: Content of the provenance file, empty if there is none.
        warnings: What is missing or damaged in the folder.
    """

    files: tuple[Path, ...]
    provenance: dict[str, Any]
    warnings: tuple[str, ...]


def find_bag_files(path: Path) -> BagFiles:
    """Find the files of a log.

    Args:
        path: A rosbag2 folder or a single .mcap or .db3 file.

    Raises:
        InputError: There is nothing to read, or the storage is another one.
    """
    warnings: list[str] = []
    if path.is_file():
        if path.suffix not in STORAGES.values():
            raise InputError(
                f"{path} is a '{path.suffix}' file, allowed is a rosbag2 folder or an .mcap or .db3 file; convert it"
            )
        return BagFiles((path,), read_provenance(path.parent, warnings), tuple(warnings))
    if not path.is_dir():
        raise InputError(f"there is no log at {path}; give a rosbag2 folder, an .mcap or a .db3 file")
    files = _listed(path, warnings) or sorted(file for suffix in STORAGES.values() for file in path.glob(f"*{suffix}"))
    if not files:
        present = ", ".join(sorted(p.name for p in path.iterdir())[:10]) or "nothing"
        raise InputError(
            f"the folder {path} has no .mcap or .db3 file (it holds {present}); give the folder of one recording"
        )
    return BagFiles(tuple(files), read_provenance(path, warnings), tuple(warnings))


def _listed(folder: Path, warnings: list[str]) -> list[Path]:
    """Return the files listed in metadata.yaml; empty if it cannot be used."""
    if not (folder / METADATA_FILE).is_file():
        warnings.append(f"{folder} has no {METADATA_FILE}; all its message files were read")
        return []
    try:
        content = read_yaml(folder / METADATA_FILE)
        information = content["rosbag2_bagfile_information"]
        listed = (PurePosixPath(str(name)).name for name in information["relative_file_paths"])
        names = list(dict.fromkeys(listed))  # each file once, however often it is listed
        storage, mode = str(information.get("storage_identifier")), str(information.get("compression_mode") or "")
    except (InputError, KeyError, TypeError, AttributeError) as error:
        warnings.append(f"{folder / METADATA_FILE} cannot be used ({error}); all message files of the folder were read")
        return []
    if storage not in STORAGES:
        raise InputError(
            f"the log {folder} has the storage '{storage}', allowed are {' and '.join(STORAGES)}; convert it with "
            "'ros2 bag convert'"
        )
    if mode.lower() not in ("", "none"):
        raise InputError(
            f"the log {folder} has the compression mode '{mode}', allowed is compression inside MCAP chunks; "
            "convert it with 'ros2 bag convert'"
        )
    missing = {name for name in names if not is_file(folder / name)}
    if missing:
        some = ", ".join(sorted(missing)[:MOST_WARNINGS]) + (" and more" if len(missing) > MOST_WARNINGS else "")
        warnings.append(f"{folder} lacks {some}, listed in {METADATA_FILE}; the other files were read")
    return [folder / name for name in names if name not in missing]
