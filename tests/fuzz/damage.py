"""Hypothesis strategies for inputs that others wrote: valid ones with damage, and texts and trees that were made up."""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator, Sequence
from copy import deepcopy
from typing import Any

from hypothesis import strategies as st

CLAIMS = (0, 1, 0x7F, 0xFF, 0xFFFF, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF, 2**63 - 1, 2**63, 2**64 - 1)
"""Lengths that a damaged or hostile file may claim."""
JUNK: tuple[Any, ...] = (
    *(None, True, False, 0, 1, -1, 2**63, 10**400, -(10**400), 0.0, -0.0, 1e-320, 5e-324, 1e308, -1e308, 0.1),
    *(
        float("nan"),
        float("inf"),
        "",
        " ",
        "x",
        "nan",
        "1e999",
        "-1",
        "e12",
        "motor_1",
        "motor_0",
        "motor_99",
        "\n",
        "\0",
    ),
    *(
        "../..",
        "/dev/zero",
        "~",
        "\u202e",
        "\U0001f600",
        "x" * 3000,
        f"{'x' * 3000}.yaml",
        [],
        [[]],
        [None],
        [1, 2, 3],
        [0.5] * 50,
        {},
    ),
    *({"": 0}, {"value": 1}, {"value": 1, "unit": "m"}, {"a": {"a": {"a": {}}}}, [{"a": [{}]}] * 3),
)
"""Values that take the place of one in a valid tree."""

_EDITS = ("flip", "byte", "claim32", "claim64", "cut", "remove", "insert", "repeat", "swap")


@st.composite
def damaged(draw: st.DrawFn, samples: Sequence[bytes]) -> bytes:
    """One of the samples with up to four edits: bits, bytes, claims, pieces cut off, removed, put in, repeated."""
    data = bytearray(draw(st.sampled_from(samples)))
    for _ in range(draw(st.integers(0, 4))):
        if not data:
            break
        place = draw(st.integers(0, len(data) - 1))
        length = draw(st.integers(1, 64))
        _edit(data, draw(st.sampled_from(_EDITS)), place, length, draw)
    return bytes(data)


def _edit(data: bytearray, edit: str, place: int, length: int, draw: st.DrawFn) -> None:
    if edit == "flip":
        data[place] ^= 1 << draw(st.integers(0, 7))
    elif edit == "byte":
        data[place] = draw(st.integers(0, 255))
    elif edit in ("claim32", "claim64"):
        code = draw(st.sampled_from("<>")) + ("I" if edit == "claim32" else "Q")
        size = struct.calcsize(code)
        data[place : place + size] = struct.pack(code, draw(st.sampled_from(CLAIMS)) % 2 ** (8 * size))
    elif edit == "cut":
        del data[place:]
    elif edit == "remove":
        del data[place : place + length]
    elif edit == "insert":
        data[place:place] = draw(st.binary(max_size=length))
    elif edit == "repeat":
        data[place:place] = data[place : place + length] * draw(st.integers(1, 50))
    else:
        other = draw(st.integers(0, len(data) - 1))
        data[place : place + length], data[other : other + length] = (
            data[other : other + length],
            data[place : place + length],
        )


def _places(tree: Any) -> Iterator[tuple[Any, Any]]:
    """Every container in a tree with each of its keys."""
    if isinstance(tree, (dict, list)):
        for key in list(tree) if isinstance(tree, dict) else range(len(tree)):
            yield tree, key
            yield from _places(tree[key])


@st.composite
def changed(draw: st.DrawFn, trees: Sequence[Any]) -> Any:
    """One of the trees with up to four values replaced, removed, renamed, moved or repeated."""
    tree = deepcopy(draw(st.sampled_from(trees)))
    for _ in range(draw(st.integers(1, 4))):
        places = list(_places(tree))
        if not places:
            break
        holder, key = draw(st.sampled_from(range(len(places))).map(places.__getitem__))
        edit = draw(st.sampled_from(("replace", "scale", "remove", "rename", "move", "repeat")))
        _change(holder, key, edit, draw, places)
    return tree


def _change(holder: Any, key: Any, edit: str, draw: st.DrawFn, places: list[tuple[Any, Any]]) -> None:
    value = holder[key]
    if edit == "remove":
        del holder[key]
    elif edit == "rename" and isinstance(holder, dict):
        holder[draw(st.sampled_from(("", "x", "value", "0", "name", key + "s")))] = holder.pop(key)
    elif edit == "scale" and isinstance(value, float):
        holder[key] = value * draw(st.sampled_from((-1, 0, 1e-9, 1e9, 1e200, 0.5)))
    elif edit == "move":
        other, there = draw(st.sampled_from(range(len(places))).map(places.__getitem__))
        holder[key] = deepcopy(other[there]) if _has(other, there) else None
    elif edit == "repeat":
        holder[key] = [deepcopy(value) for _ in range(draw(st.integers(0, 300)))]
    else:
        holder[key] = deepcopy(draw(st.sampled_from(JUNK)))


def _has(holder: Any, key: Any) -> bool:
    return key in holder if isinstance(holder, dict) else key < len(holder)


def as_text(tree: Any) -> bytes:
    """Write a tree as JSON, which is YAML too, except for .nan and .inf."""
    text = json.dumps(tree, ensure_ascii=False)
    return text.replace("-Infinity", "-.inf").replace("Infinity", ".inf").replace("NaN", ".nan").encode()


WORDS = (
    *(
        "a",
        "-",
        ":",
        "? ",
        "{",
        "}",
        "[",
        "]",
        ",",
        "&a ",
        "*a",
        "&b ",
        "*b",
        "<<: ",
        "!!python/object:os.system ",
        "!!int ",
    ),
    *(
        "!!binary ",
        "!!timestamp ",
        "!!set ",
        "!!omap ",
        "!!float ",
        "|",
        ">",
        "'",
        '"',
        "#",
        "%YAML 1.1\n",
        "---\n",
        "...\n",
        "\n",
    ),
    *(
        "\n  ",
        "\t",
        " ",
        "0x1F",
        "0o17",
        "1_000",
        ".inf",
        "2001-01-01",
        "12:30:45",
        "~",
        "null",
        "\x07",
        "\ufeff",
        "\x85",
        "=",
        "\\x41",
    ),
)
"""Pieces of YAML."""
yaml_texts = st.lists(st.sampled_from(WORDS), max_size=40).map(lambda words: "".join(words).encode())
"""Texts that are nearly YAML."""
_KEYS = ("name", "robot", "time", "columns", "value", "bodies", "x", "relative", "motor_1", "stiffness", "level")
lines = st.lists(
    st.one_of(
        st.sampled_from(
            (*_KEYS, "@", ":", "=", ":=", ",", ".", "/", " ", "-", "..", "floors", "nan", "inf", "1e999", "5", "0.03")
        ),
        st.text(max_size=5),
    ),
    max_size=12,
).map(lambda words: "".join(words).encode(errors="replace"))
"""Values of an option on the command line."""
