"""Fragments of HTML for cells of a notebook."""

from __future__ import annotations

from flexros.report.base import Paragraph, TextTable, Tiles
from flexros.report.notebook import MOST_ROWS, notebook_html


def test_text_is_escaped() -> None:
    html = notebook_html("a < b", [Paragraph("<script>alert(1)</script>", "warning")])
    assert "<script>" not in html
    assert "a &lt; b" in html


def test_tiles_and_tables_are_there() -> None:
    table = TextTable(("Mode", "frequency [Hz]"), (("group",), ("1", "5.17")), "Modes.")
    html = notebook_html("", [Tiles((("Path error", "0.329", "mm", "rms 0.157 mm"),)), table])
    for text in ("<b>0.329</b> mm", "<td>5.17</td>", 'colspan="2"', "Modes."):
        assert text in html


def test_long_tables_are_cut_and_counted() -> None:
    rows = tuple((str(number),) * 2 for number in range(MOST_ROWS + 7))
    html = notebook_html("", [TextTable(("a", "b"), rows, "")])
    assert f"<td>{MOST_ROWS}</td>" not in html
    assert "7 more rows" in html
