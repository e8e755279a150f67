"""The house: tests mirror the package, modules stay small, whatever is public is described."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

CHECKOUT = Path(__file__).parents[2]
MODULES = sorted([*(CHECKOUT / "flexros").rglob("*.py"), *(CHECKOUT / "nodes").rglob("*.py")])
ROOMS = sorted(path.name for path in (CHECKOUT / "flexros").iterdir() if any(path.glob("[!_]*.py")))
# Folders of tests that stand for no room: house contracts, stored results, benchmarks, oracles the tests compare with,
# what is read from others in all rooms.
NOT_ROOMS = {"contracts", "golden", "bench", "oracles", "fuzz", "soak", "nodes"}
LONGEST_MODULE = 300
LONGEST_FUNCTION = 40
# Module -> why it is one indivisible piece.
LONG_MODULES: dict[str, str] = {
    "flexros/robot/symbolic/dynamics.py": "recursions that share their frames",
}
# "module:function" -> why it is one indivisible piece.
LONG_FUNCTIONS: dict[str, str] = {}

Definition = ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef
Function = ast.FunctionDef | ast.AsyncFunctionDef


def name_of(path: Path) -> str:
    return str(path.relative_to(CHECKOUT))


def definitions(path: Path) -> list[Definition]:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    return [node for node in ast.walk(tree) if isinstance(node, Definition)]


def statement_lines(function: Function) -> int:
    """Count the lines of a function's body without its docstring."""
    body = function.body[1:] if ast.get_docstring(function) else function.body
    return body[-1].end_lineno - body[0].lineno + 1 if body else 0  # type: ignore[operator]


def undocumented(path: Path) -> list[str]:
    """List public functions and classes at module level, and public methods of public classes, without a docstring."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    top = [node for node in tree.body if isinstance(node, Definition) and not node.name.startswith("_")]
    members = [
        member
        for node in top
        if isinstance(node, ast.ClassDef)
        for member in node.body
        if isinstance(member, Function) and not member.name.startswith("_")
    ]
    return [node.name for node in (*top, *members) if not ast.get_docstring(node)]


@pytest.mark.parametrize("room", [*ROOMS, "nodes"])
def test_room_has_tests(room: str) -> None:
    assert list((CHECKOUT / "tests" / room).rglob("test_*.py"))


def test_no_tests_without_a_room() -> None:
    folders = {path.name for path in (CHECKOUT / "tests").iterdir() if any(path.glob("*.py"))}
    assert folders <= {*ROOMS, *NOT_ROOMS}


@pytest.mark.parametrize("path", MODULES, ids=name_of)
def test_module_is_documented(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert not text.strip() or ast.get_docstring(ast.parse(text))
    assert undocumented(path) == []


def test_modules_are_short_or_excused() -> None:
    long = {name_of(path) for path in MODULES if len(path.read_text(encoding="utf-8").splitlines()) > LONGEST_MODULE}
    assert long == set(LONG_MODULES)


def test_functions_are_short_or_excused() -> None:
    long = {
        f"{name_of(path)}:{node.name}"
        for path in MODULES
        for node in definitions(path)
        if isinstance(node, Function) and statement_lines(node) > LONGEST_FUNCTION
    }
    assert long == set(LONG_FUNCTIONS)
