"""Provenance file in the folder of a log: scenario, seed, versions, model hash."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from flexros.config.text_file import read_json
from flexros.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

PROVENANCE_FILE = "provenance.json"


def provenance_text(provenance: Mapping[str, Any]) -> str:
    """Return the JSON text of a provenance.

    Args:
        provenance: Text, finite numbers, lists and mappings of them.

    Returns:
        The content of the file.

    Raises:
        InputError: A value cannot be represented in JSON.
    """
    try:
        return json.dumps(dict(provenance), indent=2, sort_keys=True, allow_nan=False) + "\n"
    except (TypeError, ValueError) as error:
        raise InputError(
            f"the provenance cannot be written as JSON: {error}; give text, finite numbers, lists and mappings"
        ) from error


def read_provenance(folder: Path, warnings: list[str]) -> dict[str, Any]:
    """Read the provenance file of a log.

    Args:
        folder: The folder of the log.
        warnings: Receives what is damaged in it.

    Returns:
        Its content, empty if there is none.
    """
    path = folder / PROVENANCE_FILE
    if not path.is_file():
        return {}
    try:
        content = read_json(path)
    except InputError as error:
        warnings.append(f"the provenance of the log cannot be read ({error}); it is ignored")
        return {}
    if not isinstance(content, dict):
        warnings.append(f"{path} holds a {type(content).__name__}, allowed is a mapping; it was ignored")
        return {}
    return content
