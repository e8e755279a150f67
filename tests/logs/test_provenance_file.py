from __future__ import annotations

import pytest

from flexros.errors import InputError
from flexros.logs.provenance_file import PROVENANCE_FILE, provenance_text, read_provenance

PROVENANCE = {"scenario": "circle_pd", "seed": 3, "versions": {"flexros": "0.1"}, "effects": []}


def test_written_is_read(tmp_path):
    (tmp_path / PROVENANCE_FILE).write_text(provenance_text(PROVENANCE))
    warnings: list[str] = []
    assert read_provenance(tmp_path, warnings) == PROVENANCE
    assert warnings == []


def test_text_does_not_depend_on_the_order_of_keys():
    assert provenance_text(PROVENANCE) == provenance_text(dict(reversed(PROVENANCE.items())))


@pytest.mark.parametrize("value", [float("nan"), object()])
def test_what_has_no_form_in_json_is_refused(value):
    with pytest.raises(InputError, match="the provenance cannot be written as JSON: .*; give text, finite numbers"):
        provenance_text({"x": value})


def test_absent_file(tmp_path):
    assert read_provenance(tmp_path, []) == {}


@pytest.mark.parametrize(
    ("content", "warning"),
    [(b"{", "cannot be read"), (b"\xff", "cannot be read"), (b"[1]", "holds a list, allowed is a mapping")],
)
def test_damage_is_named(tmp_path, content, warning):
    (tmp_path / PROVENANCE_FILE).write_bytes(content)
    warnings: list[str] = []
    assert read_provenance(tmp_path, warnings) == {}
    assert warning in warnings[0]
    assert PROVENANCE_FILE in warnings[0]
