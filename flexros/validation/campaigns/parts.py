"""Parts of a campaign: computed on the workers, kept in files, never computed twice."""

from __future__ import annotations

import json
from collections import Counter
from typing import TYPE_CHECKING, Any

from flexros.atomic_file import write_whole
from flexros.config.text_file import read_json
from flexros.errors import InputError
from flexros.provenance import code_version, versions
from flexros.scheduler import finished

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping
    from pathlib import Path

    from distributed import Client

LARGEST_PART = 256 * 2**20
"""Largest file of a part [byte], chosen."""
CODE = "code"
"""Key of a part that names the version of the code that computed it."""
SETTINGS = "settings.json"
"""File that says what the parts of a folder belong to."""


def claim_folder(folder: Path, settings: Mapping[str, Any]) -> None:
    """Check that the parts in a folder belong to these settings.

    Args:
        folder: The folder, which exists; an empty one is claimed.
        settings: What the parts depend on, for JSON.

    Raises:
        InputError: The folder holds parts that were made with other settings, or its settings are damaged.
    """
    file, text = folder / SETTINGS, json.dumps(settings, indent=1, sort_keys=True)
    if not file.exists():
        write_whole(file, text)
        return
    before = _read(file)
    now = json.loads(text)
    differing = sorted(key for key in {*before, *now} if before.get(key) != now.get(key))
    if differing:
        key = differing[0]
        raise InputError(
            f"the folder '{folder}' holds parts with {key} {_short(before.get(key))}, but now it is "
            f"{_short(now.get(key))}; give another folder, or remove this one",
            "work",
        )


def finished_parts(
    folder: Path,
    client: Client,
    jobs: Mapping[str, tuple[Any, ...]],
    function: Callable[..., dict[str, Any]],
    progress: Callable[[int], None],
    shared: tuple[Any, ...] = (),
) -> dict[str, dict[str, Any]]:
    """Compute the missing parts and return all.

    Args:
        folder: Where parts are kept, one JSON file each; written as soon as a part is finished.
        client: Dask client whose workers compute.
        jobs: Arguments of the function by the name of the part, which becomes that of its file.
        function: What computes a part from its arguments; gives what JSON can hold.
        progress: Called with the number of parts that are there.
        shared: First arguments of every part; they are sent to each worker once, not with every part.

    Returns:
        Results by name of the part, in the order of the jobs.
    """
    code = code_version()
    missing = {name: arguments for name, arguments in jobs.items() if not _file(folder, name).exists()}
    progress(len(jobs) - len(missing))
    sent = client.scatter(list(shared), broadcast=True, hash=False) if shared and missing else []
    submitted = {client.submit(function, *sent, *arguments, pure=False): name for name, arguments in missing.items()}
    for done, job in enumerate(finished(client, submitted), start=1):
        write_whole(_file(folder, submitted[job]), json.dumps({**job.result(), CODE: code}))
        progress(len(jobs) - len(missing) + done)
    return {name: _read(_file(folder, name)) for name in jobs}


def versions_of(parts: Iterable[Mapping[str, Any]]) -> dict[str, str]:
    """Return the versions of packages, and of the code of every part.

    Args:
        parts: Results of parts; a campaign that continued after a change has several versions.
    """
    counted = Counter(str(part.get(CODE, "unknown")) for part in parts)
    code = ", ".join(f"{name} ({number} parts)" for name, number in sorted(counted.items()))
    return {**versions(), "commit": code}


def _read(file: Path) -> dict[str, Any]:
    """Read a file of our own, which may have been damaged since."""
    content = read_json(file, LARGEST_PART)
    if not isinstance(content, dict):
        raise InputError(f"{file} holds no mapping; remove it, so that it is made again")
    return content


def _file(folder: Path, name: str) -> Path:
    return folder / f"{name}.json"


def _short(value: Any) -> str:
    text = json.dumps(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
