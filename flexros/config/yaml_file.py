"""Reading YAML 1.2 files with errors that name file and line."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.error import MarkedYAMLError, YAMLError

from flexros.errors import InputError


def read_yaml(path: Path) -> dict[str, Any]:
    """Read a YAML mapping.

    Args:
        path: File to read; numbers follow YAML 1.2, so `1e5` is a number.

    Returns:
        The mapping at the top of the file.

    Raises:
        InputError: The file is missing, not YAML, has a key twice, or is not a mapping.
    """
    try:
        text = Path(path).read_text(encoding="utf-8")
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror}; give the path of a readable YAML file") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{path} is not a text file (byte {error.start} is not UTF-8); give a YAML file") from error
    try:
        content = YAML(typ="safe", pure=True).load(text)
    except MarkedYAMLError as error:
        place = f", line {error.problem_mark.line + 1}" if error.problem_mark else ""
        problem = str(error.problem or error.context).splitlines()[0]
        raise InputError(f"{path}{place}: broken YAML, {problem}; correct the file") from error
    except (YAMLError, ValueError, RecursionError) as error:
        raise InputError(f"{path}: broken YAML, {str(error).splitlines()[0]}; correct the file") from error
    if not isinstance(content, dict):
        given = "nothing" if content is None else f"a {type(content).__name__}"
        raise InputError(f"{path}: the file holds {given}, allowed is a mapping of keys to values; correct the file")
    return content


def read_rows(path: Path) -> dict[str, dict[str, Any]]:
    """Read a YAML file that lists things by name.

    Args:
        path: File to read.

    Returns:
        The keys of each thing by its name.

    Raises:
        InputError: The file cannot be read, or a name is no text or holds no mapping.
    """
    content = read_yaml(path)
    for name, row in content.items():
        if not isinstance(name, str) or not isinstance(row, dict):
            raise InputError(f"{path}, key {name}: allowed is a name with a mapping of keys; correct the file")
    return content
