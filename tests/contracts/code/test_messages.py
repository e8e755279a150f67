"""Messages of the library name arguments and values; options of a command belong to the command line."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

CHECKOUT = Path(__file__).resolve().parents[3]
COMMANDS = (CHECKOUT / "flexros" / "cli", CHECKOUT / "flexros" / "validation" / "commands")
OPTION = re.compile(r"(?<![\w(-])--[a-z][a-z-]+")
WHOLE_COMMAND = re.compile(r"flexros [a-z-]+ [^;]*--[a-z]|^--[a-z-]+$")
"""A command to be copied, or a word of one that is put together: not a message that names an option."""


def _texts(file: Path) -> Iterator[tuple[int, str]]:
    """Yield the strings of a module with their lines, its docstrings left out."""
    text = file.read_text(encoding="utf-8")
    if not OPTION.search(text):
        return  # most modules: not parsed
    tree = ast.parse(text)
    documented = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in documented:
            yield node.lineno, node.value


@pytest.mark.slow
def test_no_message_of_the_library_names_an_option_of_the_command_line() -> None:
    modules = [
        file
        for package in ("flexros", "nodes")
        for file in sorted((CHECKOUT / package).rglob("*.py"))
        if not any(file.is_relative_to(room) for room in COMMANDS)
    ]
    assert len(modules) > 500
    named = [
        f"{file.relative_to(CHECKOUT)}:{line}: {text}"
        for file in modules
        for line, text in _texts(file)
        if OPTION.search(text) and not WHOLE_COMMAND.search(text)
    ]
    assert named == []
