"""JSON text of records, for files and for the output of commands."""

from __future__ import annotations

import json
import math
from typing import Any


def json_text(content: Any) -> str:
    """Return indented JSON text of nested dicts, lists, tuples, numbers and strings; non-finite numbers become null."""
    return json.dumps(_finite(content), indent=2, allow_nan=False) + "\n"


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(key): _finite(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(entry) for entry in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
