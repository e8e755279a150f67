"""Message definitions are read within limits."""

from __future__ import annotations

import pytest
from mcap.records import Schema

from flexros.errors import InputError
from flexros.input_limits import DEEPEST_TYPE, LARGEST_DEFINITION, MOST_FIELDS
from flexros.logs.messages.definition_parts import parse_definition

HEAD = "=" * 80 + "\n"


def schema(text: str, encoding: str = "ros2msg") -> Schema:
    return Schema(id=1, data=text.encode(), encoding=encoding, name="x/msg/X")


def idl(members: str, before: str = "") -> Schema:
    return schema(f"module x {{ module msg {{ {before} struct X {{ {members} }}; }}; }};", "ros2idl")


def chain(levels: int) -> str:
    return "".join(f"T{k} a\n{HEAD}MSG: x/T{k}\n" for k in range(levels)) + "int8 a\n"


def names(one: Schema) -> list[str]:
    return [name for name, _ in parse_definition(one)["x/msg/X"][1]]


def test_idl_of_a_recorder_is_read() -> None:
    text = (
        HEAD
        + 'IDL: x/msg/X\n// Made by a tool ("quoted"\nmodule x { module msg { module X_Constants { const long N = -3; '
        '@verbatim (language="comment", text="(a" "b<") const string S = "a<<(b"; }; @final struct X { '
        '@unit(value="m") @key double q; sequence<double, 4> u; string<5> s; long a[3]; }; }; };'
    )
    assert names(schema(text, "ros2idl")) == ["q", "u", "s", "a"]


@pytest.mark.parametrize(
    ("one", "message"),
    [
        (schema("# " + "x" * LARGEST_DEFINITION), "it has 65538 bytes, allowed are 65536"),
        (schema(f"string[{MOST_FIELDS}] a\nint8 b\n"), "it has 2001 fields, allowed are 2000"),
        (schema("int8[0] a\n"), "an array in it has no entries"),
        (schema("Y a\n"), "it lacks the type x/msg/Y"),
        (schema("X a\n"), "its type x/msg/X contains itself"),
        (schema(chain(DEEPEST_TYPE)), "its types nest more than 20 levels deep"),
        (idl("double q;", "const long N = (1);"), "a constant in it is an expression"),
        (idl("double q;", "const long N = 1 << 9;"), "a constant in it is an expression|nests brackets"),
        (idl(f"{'sequence<' * 4}double{'>' * 4} q;"), "it nests brackets more than 3 deep"),
    ],
    ids=["large", "fields", "empty array", "lacking", "circle", "deep", "parentheses", "shift", "brackets"],
)
def test_what_is_beyond_a_limit_is_refused(one: Schema, message: str) -> None:
    with pytest.raises(InputError, match=message):
        parse_definition(one)


def test_what_is_within_the_limits_is_read() -> None:
    assert names(schema(f"string[{MOST_FIELDS - 1}] a\nfloat64[1000000] b\n")) == ["a", "b"]
    assert names(schema(chain(DEEPEST_TYPE - 1))) == ["a"]
