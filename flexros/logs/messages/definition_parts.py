"""Message definitions from files, read within limits, because the parsing library generates code from them.

Names cannot inject code: the grammar allows letters, digits, underscores and slashes, and constants are written by
`repr`. However, the parsing time grows exponentially with nested parentheses and brackets in IDL, and the library
generates code for every entry of some arrays.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from flexros.errors import InputError
from flexros.input_limits import DEEPEST_TYPE, LARGEST_DEFINITION, MOST_FIELDS

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from mcap.records import Schema
    from rosbags.interfaces.typing import FieldDesc, Typesdict

_HEAD_OF_IDL = re.compile(r"^(?:={80}|IDL: .*)$", re.MULTILINE)
_TEXT_OR_COMMENT = re.compile(r'"(?:[^"\\\n]|\\.)*"|//[^\n]*|/\*.*?\*/', re.DOTALL)
_ANNOTATION = re.compile(r"@\w+(?:::\w+)*\s*(?:\([^()]*\))?")
_CONSTANT = re.compile(r"=\s*([^;]*)")
_LITERAL = re.compile(r'-?[\w.+-]*|""|\'.\'')
_DEEPEST_BRACKET = 3


def parse_definition(schema: Schema) -> Typesdict:
    """Read the definition of a message type.

    Args:
        schema: Schema record of a file; its encoding is one of `PARSERS`.

    Returns:
        Constants and fields of the type and of all nested types, by type.

    Raises:
        InputError: It is larger or deeper than allowed, or lacks a nested type.
        Exception: It is not a definition; the errors of the parser have no common base class.
    """
    if len(schema.data) > LARGEST_DEFINITION:
        raise InputError(f"it has {len(schema.data)} bytes, allowed are {LARGEST_DEFINITION}")
    types = PARSERS[schema.encoding](schema.data.decode(errors="replace"), schema.name)
    if (n := sum(_n_fields(fields) for _, fields in types.values())) > MOST_FIELDS:
        raise InputError(f"it has {n} fields, allowed are {MOST_FIELDS}")
    if _levels(types, schema.name, (), {}) > DEEPEST_TYPE:
        raise InputError(f"its types nest more than {DEEPEST_TYPE} levels deep")
    return types


def _from_msg(text: str, name: str) -> Typesdict:
    from rosbags.typesys import get_types_from_msg

    return get_types_from_msg(text, name)


def _from_idl(text: str, name: str) -> Typesdict:
    from rosbags.typesys import get_types_from_idl

    plain = _TEXT_OR_COMMENT.sub(lambda match: '""' if match[0].startswith('"') else " ", _HEAD_OF_IDL.sub("", text))
    plain = _ANNOTATION.sub("", plain)
    depth = 0
    for bracket in re.findall("[<>]", plain):
        depth += 1 if bracket == "<" else -1
        if depth > _DEEPEST_BRACKET:
            raise InputError(f"it nests brackets more than {_DEEPEST_BRACKET} deep")
    if "(" in plain or not all(_LITERAL.fullmatch(value.strip()) for value in _CONSTANT.findall(plain)):
        raise InputError("a constant in it is an expression; allowed are numbers and texts")
    return get_types_from_idl(plain)


PARSERS: Mapping[str, Callable[[str, str], Typesdict]] = {"ros2msg": _from_msg, "ros2idl": _from_idl}
"""Parser of a definition, by the encoding of the schema."""


def _n_fields(fields: list[tuple[str, FieldDesc]]) -> int:
    return sum(max(1, _unrolled(desc)) for _, desc in fields)


def _unrolled(desc: FieldDesc) -> int:
    """Entries of a field for each of which code is made."""
    from rosbags.interfaces import Nodetype

    if desc[0] != Nodetype.ARRAY:
        return 1
    entry, length = desc[1]
    if not length:
        raise InputError("an array in it has no entries")  # messages could hold any number of such
    numbers = entry[0] == Nodetype.BASE and entry[1][0] not in ("string", "wstring")
    return 1 if numbers else int(length)


def _levels(types: Typesdict, name: str, outer: tuple[str, ...], known: dict[str, int]) -> int:
    """Return the nesting depth of a type."""
    from rosbags.interfaces import Nodetype

    if name not in types:
        raise InputError(f"it lacks the type {name}")
    if name in outer:
        raise InputError(f"its type {name} contains itself")
    if name not in known:
        entries = [d[1][0] if d[0] in (Nodetype.ARRAY, Nodetype.SEQUENCE) else d for _, d in types[name][1]]
        nested = [entry[1] for entry in entries if entry[0] == Nodetype.NAME]
        known[name] = 1 + max((_levels(types, inner, (*outer, name), known) for inner in nested), default=0)
    return known[name]
