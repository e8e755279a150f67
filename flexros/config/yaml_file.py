"""Reading YAML 1.2 files with errors that name file and line."""

from __future__ import annotations

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


def read_yaml(path: Path) -> dict[str, Any]:
    """Read a YAML mapping.

    Args:
        path: File to read; numbers follow YAML 1.2, so `1e5` is a number.

    Returns:
        The mapping at the top of the file.

    Raises:
        InputError: The file is missing, too large, not YAML, has a key twice, or is not a mapping.
    """
    content = parse_yaml(read_text(Path(path), "YAML"), str(path))
    if not isinstance(content, dict):
        given = "nothing" if content is None else f"a {type(content).__name__}"
        raise InputError(f"{path}: the file holds {given}, allowed is a mapping of keys to values; correct the file")
    return content


def parse_yaml(text: str, source: str) -> Any:
    """Read YAML.

    Args:
        text: The text.
        source: Where it came from; opens error texts.

    Returns:
        Its content: plain values, lists and mappings.

    Raises:
        InputError: It is not YAML, has a key twice, or more or deeper values than allowed.
    """
    reader = YAML(typ="safe", pure=True)
    try:
        top = reader.compose(text)
        if problem := "" if top is None else _excess(top):
            raise InputError(f"{source}: {problem}")
        return None if top is None else reader.constructor.construct_document(top)
    except InputError:
        raise
    except MarkedYAMLError as error:
        place = f", line {error.problem_mark.line + 1}" if error.problem_mark else ""
        problem = (str(error.problem or error.context).splitlines() or ["unknown"])[0]
        raise InputError(f"{source}{place}: broken YAML, {problem}; correct the file") from error
    except Exception as error:  # values that look like numbers, dates or tags fail in many ways
        problem = (str(error).splitlines() or [type(error).__name__])[0]
        raise InputError(f"{source}: broken YAML, {problem}; correct the file") from error


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


def _excess(top: Node) -> str:
    """Say how a document is too large or too deep with its aliases written out; nothing if it is not."""
    extents: dict[int, tuple[int, int]] = {}
    begun: set[int] = set()
    waiting = [top]
    while waiting:
        node = waiting[-1]
        within = _within(node)
        unknown = [inner for inner in within if id(inner) not in extents]
        if not unknown:
            known = [extents[id(inner)] for inner in within]
            extents[id(node)] = 1 + sum(n for n, _ in known), 1 + max((d for _, d in known), default=0)
            waiting.pop()
        elif id(node) in begun:
            return "an alias stands for what it lies in, so the content has no end; remove it"
        else:
            begun.add(id(node))
            waiting += unknown
    number, depth = extents[id(top)]
    if number > MOST_NODES:
        return f"it has more than the {MOST_NODES} values that are allowed, aliases written out; shorten it"
    if depth > DEEPEST_NODE:
        return f"its values lie {depth} levels deep, allowed are {DEEPEST_NODE}; flatten it"
    return ""


def _within(node: Node) -> list[Node]:
    """Nodes directly in a node: entries, or keys and values."""
    if isinstance(node, MappingNode):
        return [inner for pair in node.value for inner in pair]
    return list(node.value) if isinstance(node, SequenceNode) else []
