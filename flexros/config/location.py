"""Location of the data files of FlexROS in a checkout, a pip environment or a colcon workspace."""

from __future__ import annotations

from pathlib import Path

from flexros.errors import InputError


def data_folder(name: str) -> Path:
    """Return a data folder of the installation.

    Args:
        name: Top-level folder of the project, e.g. "msgs_config".

    Returns:
        Its path: next to the package in a checkout, else `share/flexros/<name>` of the install prefix.

    Raises:
        InputError: The installation lacks the folder.
    """
    package = Path(__file__).resolve().parent.parent
    for parent in package.parents:
        for candidate in (parent / name, parent / "share" / "flexros" / name):
            if candidate.is_dir() and any(candidate.glob("*.yaml")):
                return candidate
    raise InputError(f"the folder '{name}' was not found above {package}; install FlexROS again")
