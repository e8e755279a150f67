from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from flexros.json_text import json_text


def test_non_finite_numbers_become_null_at_any_depth() -> None:
    content = {"a": [1.5, float("nan")], 2: {"b": (np.float64(np.inf), True, None, "x")}}
    assert json.loads(json_text(content)) == {"a": [1.5, None], "2": {"b": [None, True, None, "x"]}}


def test_text_ends_with_its_only_blank_line_feed() -> None:
    assert json_text({"a": 1}) == '{\n  "a": 1\n}\n'


def test_what_is_no_record_is_refused() -> None:
    with pytest.raises(TypeError):
        json_text({"a": Path("x")})
