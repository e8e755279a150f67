"""What commands print: tables for people, JSON for programs."""

from __future__ import annotations

import json
import math
from typing import Any

from rich.console import Console
from rich.progress import Progress

console = Console(highlight=False)


def progress_bar() -> Progress:
    """Make a progress bar on stderr that leaves nothing behind, and is not there when nobody watches."""
    stderr = Console(stderr=True)
    return Progress(console=stderr, transient=True, disable=not stderr.is_terminal)


def print_json(content: Any) -> None:
    """Print an object as JSON; numbers that are not finite become null.

    Args:
        content: Nested dicts, lists, numbers and strings.
    """
    print(json.dumps(_clean(content), indent=2))


def _clean(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(key): _clean(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [_clean(entry) for entry in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
