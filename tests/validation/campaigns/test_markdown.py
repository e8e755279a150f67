"""What the pages of campaigns have in common."""

from __future__ import annotations

from flexros.validation.campaigns.markdown import logs_without_answer, table, version_line


def test_table_has_a_row_under_its_headings() -> None:
    assert table(("a", "b"), iter([("1", "2")])) == ["| a | b |", "| --- | --- |", "| 1 | 2 |"]


def test_a_case_without_answer_is_listed_with_the_end_of_its_error() -> None:
    assert logs_without_answer({}) == []
    assert logs_without_answer({"case_3": "Traceback\nValueError: 7 s\n"})[-1] == "- case_3: ValueError: 7 s"


def test_versions_are_in_one_line() -> None:
    assert version_line({"numpy": "2.1", "scipy": "1.15"}) == "Versions: numpy 2.1, scipy 1.15"
