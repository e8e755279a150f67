"""Text of a record as JSON, for files and for programs that read what a command prints."""

from __future__ import annotations

import json
import math
from typing import Any


def json_text(content: Any) -> str:
    """Write an object as JSON; numbers that JSON cannot hold (not finite) become null.

    Args:
        content: Nested dicts, lists, tuples, numbers and texts.

    Returns:
        The text, indented, with a line feed at its end.
    """
    return json.dumps(_finite(content), indent=2, allow_nan=False) + "\n"


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(key): _finite(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(entry) for entry in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
