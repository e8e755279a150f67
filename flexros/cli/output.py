"""What commands print: tables for people, JSON for programs."""

from __future__ import annotations

from typing import Any

from rich.console import Console
from rich.progress import Progress

from flexros.json_text import json_text


class _Terminal(Console):
    """Standard output; a reader that went away (`| head`) is left to the command's end."""

    def on_broken_pipe(self) -> None:
        raise BrokenPipeError


console = _Terminal(highlight=False, markup=False, emoji=False)
"""Prints texts as they are: brackets in names of files and labels are no markup."""


def say(text: str) -> None:
    """Print a line that is never broken, so that a path in it can be copied.

    Args:
        text: The line.
    """
    console.print(text, soft_wrap=True)


def progress_bar(shown: bool = True) -> Progress:
    """Make a progress bar on stderr that leaves nothing behind, and is not there when nobody watches.

    Args:
        shown: False for work within other work that has a bar already.

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
