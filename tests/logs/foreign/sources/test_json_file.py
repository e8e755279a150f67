"""JSON files."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.logs.foreign.sources import json_file
from flexros.logs.foreign.sources.json_file import JsonFile


def _written(path: Path, content: object) -> Path:
    path.write_text(json.dumps(content))
    return path


def test_list_of_samples(tmp_path: Path) -> None:
    samples = [{"time": 0.1 * k, "name": "run", "state": {"q": [k, 2 * k], "ok": True}} for k in range(3)]
    opened = JsonFile(_written(tmp_path / "log.json", samples))
    assert opened.names == ("time", "state.q[0]", "state.q[1]", "state.ok")
    read = opened.read(["time", "state.q[1]"])
    np.testing.assert_allclose(read["time"].values, [0, 0.1, 0.2])
    np.testing.assert_array_equal(read["state.q[1]"].values, [0, 2, 4])


def test_arrays_by_name(tmp_path: Path) -> None:
    opened = JsonFile(
        _written(tmp_path / "log.json", {"rate": 50, "log": {"t": [0, 1, 2], "q": [[1, 2, 3], [4, 5, 6]]}})
    )
    assert opened.names == ("log.t", "log.q[0]", "log.q[1]")
    np.testing.assert_array_equal(opened.read(["log.q[1]"])["log.q[1]"].values, [4, 5, 6])


def test_rows_without_names(tmp_path: Path) -> None:
    opened = JsonFile(_written(tmp_path / "log.json", [[0, 1], [2, 3], [4, 5]]))
    assert opened.names == ("[0]", "[1]")


def test_one_sample_per_line(tmp_path: Path) -> None:
    file = tmp_path / "log.jsonl"
    file.write_text('{"t": 0, "q": 1.5}\n\n{"t": 1, "q": 2.5}\n')
    np.testing.assert_array_equal(JsonFile(file).read(["q"])["q"].values, [1.5, 2.5])


def test_what_a_sample_lacks_is_not_a_number(tmp_path: Path) -> None:
    samples = [{"t": 0, "q": [1, 2]}, {"t": 1}, {"t": 2, "q": [None, 4]}]
    read = JsonFile(_written(tmp_path / "log.json", samples)).read(["q[0]", "q[1]"])
    np.testing.assert_array_equal(read["q[0]"].values, [1, np.nan, np.nan])
    np.testing.assert_array_equal(read["q[1]"].values, [2, np.nan, 4])


def test_lists_of_texts_and_of_different_lengths_are_no_columns(tmp_path: Path) -> None:
    content = {"t": [0, 1, 2], "names": ["a", "b", "c"], "numbers": [["1"], ["2"], ["3"]], "hits": [[1], [1, 2], []]}
    assert JsonFile(_written(tmp_path / "log.json", content)).names == ("t",)


@pytest.mark.parametrize("text", ["", "{", "[1, 2", "[" * 100_000])
def test_damaged_file(tmp_path: Path, text: str) -> None:
    file = tmp_path / "log.json"
    file.write_text(text)
    with pytest.raises(InputError, match="cannot be read as JSON"):
        JsonFile(file)


def test_levels_and_size_are_limited(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    nested: object = [1, 2]
    for _ in range(100):
        nested = {"a": nested}
    file = _written(tmp_path / "log.json", nested)
    with pytest.raises(InputError, match="more than 60 levels"):
        JsonFile(file)
    monkeypatch.setattr(json_file, "LARGEST_JSON", 10)
    with pytest.raises(InputError, match="allowed are 10 for a JSON file"):
        JsonFile(file)
