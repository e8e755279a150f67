"""Output of commands: tables for people, JSON for programs."""

from __future__ import annotations

import sys
from typing import Any

from rich.console import Console

from flexros.json_text import json_text


class _Terminal(Console):
    """Standard output; a broken pipe (`| head`) is raised, and reported at the end of the command."""

    def on_broken_pipe(self) -> None:
        raise BrokenPipeError


console = _Terminal(highlight=False, markup=False, emoji=False)
"""Prints texts verbatim: brackets in file names and labels are no markup."""


def say(text: str) -> None:
    """Print a line without wrapping it, so that a path in it can be copied.

    Args:
        text: The line.
    """
    console.print(text, soft_wrap=True)


def suggest(text: str, *, unless: bool = False) -> None:
    """Print what to do next, on stderr.

    Args:
        text: The command, and in a few words what it does.
        unless: True where the output is for programs.
    """
    if not unless:
        print(f"Next: {text}", file=sys.stderr)


def print_json(content: Any) -> None:
    """Print an object as JSON; numbers that are not finite become null.

    Args:
        content: Nested dicts, lists, numbers and strings.
    """
    print(json_text(content), end="")
