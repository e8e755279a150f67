"""Output of commands: tables for people, JSON for programs."""

from __future__ import annotations

from typing import Any

from rich.console import Console
from rich.progress import Progress

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


def progress_bar(shown: bool = True) -> Progress:
    """Make a transient progress bar on stderr, disabled where stderr is no terminal.

    Args:
        shown: False for a step of work that has a bar already.

    Returns:
        The bar.
    """
    stderr = Console(stderr=True)
    return Progress(console=stderr, transient=True, disable=not (shown and stderr.is_terminal))


def print_json(content: Any) -> None:
    """Print an object as JSON; numbers that are not finite become null.

    Args:
        content: Nested dicts, lists, numbers and strings.
    """
    print(json_text(content), end="")
