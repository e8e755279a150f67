"""Provenance of several runs: what they share stands once."""

from __future__ import annotations

from flexros.report.base import TextTable
from flexros.report.origin import folded_origin


def test_what_all_share_stands_once_below_what_differs() -> None:
    folded = folded_origin({"a": {"seed": 1, "robot": "e12"}, "b": {"seed": 2, "robot": "e12"}}, "run", "runs")
    assert folded is not None
    assert folded.summary == "Origin of the runs, and in which entries they differ: 2 entries"
    differing, common = folded.blocks
    assert isinstance(differing, TextTable)
    assert isinstance(common, TextTable)
    assert differing.header == ("Runs", "Value")
    assert differing.rows == (("seed",), ("a", "1"), ("b", "2"))
    assert common.rows == (("robot", "e12"),)


def test_one_run_has_one_table_and_none_without_entries() -> None:
    folded = folded_origin({"a": {"seed": 1}}, "run", "runs")
    assert folded is not None
    assert folded.summary == "Origin of the run: 1 entries"
    assert len(folded.blocks) == 1
    assert folded_origin({"a": {}}, "run", "runs") is None
