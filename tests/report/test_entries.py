from __future__ import annotations

from flexros.report.entries import LONGEST, differing_rows, flat_entries, grouped_rows


def test_nested_entries_are_named_by_their_path_and_empty_ones_left_out() -> None:
    nested = {"seed": 0, "scenario": {"robot": "e12", "plant": {"mass": 190.0}, "note": ""}, "list": [1, 2]}
    assert dict(flat_entries(nested)) == {
        "seed": "0", "scenario.robot": "e12", "scenario.plant.mass": "190", "list": "1, 2",
    }  # fmt: skip


def test_long_texts_are_cut() -> None:
    ((_, text),) = flat_entries({"a": "x" * 1000})
    assert text == "x" * LONGEST + " ..."


def test_entries_of_a_mapping_stand_below_its_name() -> None:
    assert grouped_rows({"a.b": "1", "c": "2", "a.d.e": "3"}) == (("c", "2"), ("a",), ("b", "1"), ("d.e", "3"))


def test_differences_are_listed_by_value() -> None:
    runs = {name: {"mass": "200", "robot": "e12"} for name in ("one", "two", "three")} | {"four": {"robot": "e12"}}
    assert differing_rows(runs) == (("mass",), ("the other 3", "200"), ("four", "-"))
