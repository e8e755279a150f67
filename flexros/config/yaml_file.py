"""Reading YAML 1.2 files with errors that name file and line."""

from __future__ import annotations

from copy import deepcopy
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ruamel.yaml import YAML
from ruamel.yaml.error import MarkedYAMLError
from ruamel.yaml.nodes import MappingNode, SequenceNode

from flexros.config.text_file import read_text
from flexros.errors import InputError
from flexros.input_limits import DEEPEST_NODE, MOST_NODES

if TYPE_CHECKING:
    from ruamel.yaml.nodes import Node

_LONGEST_KEPT = 2**16
"""Longest text whose content is kept, as nodes and commands of one process read the same files [characters]."""


def read_yaml(path: Path) -> dict[str, Any]:
    """Read a file that holds a YAML 1.2 mapping (`1e5` is a number).

    Raises:
        InputError: The file is missing, too large, not YAML, has a duplicate key, or is not a mapping.
    """
    content = parse_yaml(read_text(Path(path), "YAML"), str(path))
    if not isinstance(content, dict):
        given = "nothing" if content is None else f"a {type(content).__name__}"
        raise InputError(f"{path}: the file holds {given}, allowed is a mapping of keys to values; correct the file")
    return content


def parse_yaml(text: str, source: str) -> Any:
    """Parse YAML to plain values, lists and mappings.

    Args:
        text: The text.
        source: Its origin; prefix of error messages.

    Raises:
        InputError: It is not YAML, has a duplicate key, or more or deeper values than allowed.
    """
    try:
        return deepcopy(_parsed_once(text)) if len(text) <= _LONGEST_KEPT else _parsed(text)
    except _TooLargeError as error:
        raise InputError(f"{source}: {error}") from error
    except MarkedYAMLError as error:
        line = f", line {error.problem_mark.line + 1}" if error.problem_mark else ""
        problem = (str(error.problem or error.context).splitlines() or ["unknown"])[0]
        raise InputError(f"{source}{line}: broken YAML, {problem}; correct the file") from error
    except Exception as error:  # values that look like numbers, dates or tags fail in many ways
        problem = (str(error).splitlines() or [type(error).__name__])[0]
        raise InputError(f"{source}: broken YAML, {problem}; correct the file") from error


class _TooLargeError(Exception):
    """A document has more or deeper values than allowed."""


def _parsed(text: str) -> Any:
    reader = YAML(typ="safe", pure=True)
    top = reader.compose(text)
    if problem := "" if top is None else _excess(top):
        raise _TooLargeError(problem)
    return None if top is None else reader.constructor.construct_document(top)


_parsed_once = lru_cache(maxsize=64)(_parsed)


def read_rows(path: Path) -> dict[str, dict[str, Any]]:
    """Read a YAML file of mappings by name.

    Raises:
        InputError: The file cannot be read, a name is not text, or its value is not a mapping.
    """
    content = read_yaml(path)
    for name, row in content.items():
        if not isinstance(name, str) or not isinstance(row, dict):
            raise InputError(f"{path}, key {name}: allowed is a name with a mapping of keys; correct the file")
    return content


def _excess(top: Node) -> str:
    """Return the message for a document that is too large or too deep with aliases expanded; empty if it is not."""
    extents: dict[int, tuple[int, int]] = {}
    visited: set[int] = set()
    waiting = [top]
    while waiting:
        node = waiting[-1]
        within = _within(node)
        unknown = [inner for inner in within if id(inner) not in extents]
        if not unknown:
            known = [extents[id(inner)] for inner in within]
            extents[id(node)] = 1 + sum(n for n, _ in known), 1 + max((d for _, d in known), default=0)
            waiting.pop()
        elif id(node) in visited:
            return "an alias refers to a node that contains it, so the content is infinite; remove it"
        else:
            visited.add(id(node))
            waiting += unknown
    count, depth = extents[id(top)]
    if count > MOST_NODES:
        return f"it has more than the {MOST_NODES} values that are allowed, with aliases expanded; shorten it"
    if depth > DEEPEST_NODE:
        return f"its values are nested {depth} levels deep, allowed are {DEEPEST_NODE}; flatten it"
    return ""


def _within(node: Node) -> list[Node]:
    """Return the children of a node: entries, or keys and values."""
    if isinstance(node, MappingNode):
        return [inner for pair in node.value for inner in pair]
    return list(node.value) if isinstance(node, SequenceNode) else []
