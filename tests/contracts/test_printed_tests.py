"""Tests that the changelog and the pages name: each command selects at least one."""

from __future__ import annotations

import ast
import re
import shlex
from collections.abc import Iterator
from functools import cache
from pathlib import Path

CHECKOUT = Path(__file__).parents[2]
PAGES = [*CHECKOUT.glob("*.md"), *(CHECKOUT / "docs").rglob("*.md")]


def commands(page: Path) -> Iterator[list[str]]:
    """Yield the arguments of every `pytest ...` of a page, in a sentence or on a line of its own."""
    text = page.read_text(encoding="utf-8")
    printed = [*re.findall(r"`pytest\s([^`]+)`", text), *re.findall(r"^pytest (.+)$", text, re.MULTILINE)]
    yield from (shlex.split(" ".join(one.split())) for one in printed)


@cache
def names_in(file: Path) -> tuple[str, ...]:
    """Return name and literal parameters of each test of a file, as `-k` reads them."""
    functions = [node for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))) if _is_test(node)]
    return tuple(f"{file.name} {one.name} {' '.join(_texts(one))}".lower() for one in functions)


def _is_test(node: ast.AST) -> bool:
    return isinstance(node, ast.FunctionDef) and node.name.startswith("test_")


def _texts(function: ast.FunctionDef) -> Iterator[str]:
    """Yield the texts in the decorators of a test: its parameters, their names and marks."""
    for decorator in function.decorator_list:
        for node in ast.walk(decorator):
            if isinstance(node, ast.Constant) and isinstance(node.value, str):
                yield node.value
            if isinstance(node, ast.Attribute):
                yield node.attr


def selects(path: Path, expression: str) -> bool:
    """Return whether a file or folder holds a test that an expression of `-k` selects."""
    files = sorted(path.rglob("test_*.py")) if path.is_dir() else [path]
    ways = [way.lower().split(" and ") for way in expression.split(" or ")]
    return any(all(word in name for word in way) for way in ways for file in files for name in names_in(file))


def test_every_command_selects_a_test() -> None:
    printed = [(page, arguments) for page in PAGES for arguments in commands(page)]
    assert len(printed) > 100
    wrong = []
    for page, arguments in printed:
        paths = [CHECKOUT / one for one in arguments if one.startswith("tests/")]
        expression = arguments[arguments.index("-k") + 1] if "-k" in arguments else ""
        if not paths or not all(path.exists() and selects(path, expression) for path in paths):
            wrong.append(f"{page.name}: pytest {shlex.join(arguments)}")
    assert wrong == []


def test_a_word_that_is_in_no_name_selects_none() -> None:
    assert not selects(CHECKOUT / "tests/contracts/test_readme.py", "named and picture")
    assert selects(CHECKOUT / "tests/contracts/test_readme.py", "nothing or named_paths")
