"""Message definitions: schema text and type hash for a log, and comparison of two definitions."""

from __future__ import annotations

import json
import re
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

from flexros.errors import InputError
from flexros.input_limits import DEEPEST_TYPE

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rosbags.typesys.store import Typestore

DEFINITIONS = Path(__file__).parent / "definitions.json"
"""Definitions of the types of our topics, written by docs/generate/message_definitions.py."""

_SEPARATOR = "=" * 80
_INTEGERS = ("int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64")
_PRIMITIVES = frozenset(("bool", "byte", "char", "float32", "float64", *_INTEGERS, "string", "wstring"))

Signature: TypeAlias = tuple[tuple[str, "str | Signature", str], ...]
"""Fields in order: name, primitive type or signature of the nested type, array suffix."""


class Schema(NamedTuple):
    """Definition of a message type.

    Attributes:
        type: Name, e.g. "sensor_msgs/msg/JointState".
        text: Definition followed by those of all nested types, in the form "ros2msg".
        type_hash: Hash of the type description (REP 2011), e.g. "RIHS01_...".
    """

    type: str
    text: str
    type_hash: str


class _Field(NamedTuple):
    type: str
    array: str
    name: str


def _fields(text: str, package: str) -> Iterator[_Field]:
    for line in text.splitlines():
        words = line.split("#")[0].split()
        if len(words) < 2 or re.match(r"\s*\S+\s+\w+\s*=", line):
            continue  # blank, comment or constant
        match = re.fullmatch(r"([\w/]+(?:<=\d+)?)(\[.*\])?", words[0])
        if match is None:
            raise InputError(
                f"a message definition has the line '{line.strip()}', which is not a field; record it again"
            )
        base, array = match.groups(default="")
        plain = base.split("<=")[0]
        if plain not in _PRIMITIVES:
            base = "std_msgs/Header" if base == "Header" else base if "/" in base else f"{package}/{base}"
        yield _Field(base.replace("/msg/", "/"), array, words[1])


def signature(name: str, text: str) -> Signature:
    """Reduce a definition to the part that determines its serialisation, without comments, constants and defaults.

    Args:
        name: Type, e.g. "sensor_msgs/msg/JointState".
        text: Definition in the form "ros2msg", with its nested types.

    Returns:
        Fields in order, nested types resolved.

    Raises:
        InputError: A nested type is not defined, types nest too deeply, or a line is not a field.
    """
    root = name.replace("/msg/", "/")
    sections = {root: ""}
    for i, part in enumerate(re.split(r"^={80}\s*$", text, flags=re.MULTILINE)):
        head, _, body = part.lstrip("\n").partition("\n")
        if i == 0:
            sections[root] = part
        elif head.startswith("MSG:"):
            sections[head[4:].strip().replace("/msg/", "/")] = body

    resolved: dict[str, Signature] = {}

    def resolve(type_name: str, outer: tuple[str, ...]) -> Signature:
        if type_name not in sections or type_name in outer:
            raise InputError(
                f"the definition of {name} lacks the nested type {type_name}; record the log with full schemas"
            )
        if len(outer) >= DEEPEST_TYPE:
            raise InputError(
                f"the definition of {name} nests types {len(outer) + 1} levels deep, allowed are {DEEPEST_TYPE}; "
                "record it again"
            )
        if type_name not in resolved:
            fields = _fields(sections[type_name], type_name.split("/")[0])
            resolved[type_name] = tuple(
                (f.name, resolve(f.type, (*outer, type_name)) if "/" in f.type else f.type, f.array) for f in fields
            )
        return resolved[type_name]

    return resolve(root, ())


@lru_cache(maxsize=1)
def jazzy_types() -> Typestore:
    """Return the message types of ROS 2 Jazzy's common interfaces."""
    from rosbags.typesys import Stores, get_typestore

    return get_typestore(Stores.ROS2_JAZZY)


def _read_share(type_name: str, share: Path) -> Schema | None:
    package, _, name = type_name.split("/")
    folder = share / package / "msg"
    if not (folder / f"{name}.msg").is_file() or not (folder / f"{name}.json").is_file():
        return None
    hashes = {
        h["type_name"]: h["hash_string"] for h in json.loads((folder / f"{name}.json").read_text())["type_hashes"]
    }
    parts: list[str] = []
    seen, queue = {type_name}, [type_name]
    while queue:
        package, _, name = queue.pop(0).split("/")
        text = (share / package / "msg" / f"{name}.msg").read_text()
        parts.append(text if not parts else f"{_SEPARATOR}\nMSG: {package}/{name}\n{text}")
        for field in _fields(text, package):
            nested = field.type.replace("/", "/msg/")
            if "/" in field.type and nested not in seen:
                seen.add(nested)
                queue.append(nested)
    return Schema(type_name, "\n".join(parts), hashes[type_name])


def message_schema(type_name: str, share_folders: Sequence[Path] = ()) -> Schema:
    """Find the definition of a message type.

    Args:
        type_name: Type, e.g. "sensor_msgs/msg/JointState".
        share_folders: `share` folders of ROS 2 installations, searched first; types of the common interfaces are known
            without any.

    Returns:
        Its schema.

    Raises:
        InputError: The type is not known.
    """
    for share in share_folders:
        try:
            schema = _read_share(type_name, share)
        except (OSError, KeyError, ValueError) as error:
            raise InputError(f"the definition of {type_name} below {share} is damaged: {error}; repair it") from error
        if schema:
            return schema
    kept = _definitions().get(type_name)
    return Schema(type_name, **kept) if kept else jazzy_schema(type_name)


def is_common_type(type_name: str) -> bool:
    """Return whether a type belongs to the common interfaces of ROS 2 Jazzy."""
    return type_name in _definitions() or type_name in jazzy_types().types


def jazzy_schema(type_name: str) -> Schema:
    """Return the definition of a type of the common interfaces of ROS 2 Jazzy.

    Args:
        type_name: Type, e.g. "sensor_msgs/msg/JointState".

    Raises:
        InputError: It is none of them.
    """
    store = jazzy_types()
    if type_name not in store.types:
        raise InputError(f"unknown message type '{type_name}': allowed are the common interfaces of ROS 2 Jazzy")
    return Schema(type_name, store.generate_msgdef(type_name, ros_version=2)[0], store.hash_rihs01(type_name))


@lru_cache(maxsize=1)
def _definitions() -> dict[str, dict[str, str]]:
    """Return the definitions of the types that our topics have: the types of all interfaces load slowly."""
    definitions: dict[str, dict[str, str]] = json.loads(DEFINITIONS.read_text(encoding="utf-8"))
    return definitions
