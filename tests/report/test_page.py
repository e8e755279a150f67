"""A page of the report kit with one block of every kind."""

from __future__ import annotations

import json
import re

import numpy as np
import plotly.graph_objects as go
import pytest

from flexros.report.base import FACTORS, Folded, Heading, Listing, MagnifiedCurve, Paragraph, Picture, TextTable, Tiles
from flexros.report.page import Chapter, page_html

BLOCKS = (
    Paragraph("a < b", "lead"),
    Heading("details"),
    Listing("flexros run x", "A command."),
    Tiles((("error", "0.3", "mm", "rms 0.1 mm"),)),
    TextTable(("name", "value"), (("group",), ("k & c", "1.5")), "Values."),
    Picture(
        go.Figure(go.Scatter(x=[0.0, 1.0], y=[0.0, 1.0]), layout={"height": 200}),
        "Error drawn x{factor}.",
        (MagnifiedCurve(0, np.zeros((2, 2)), np.full((2, 2), 1.23456789)),),
        factor=FACTORS[2],
    ),
)


@pytest.fixture(scope="module")
def html() -> str:
    return page_html("Title <1>", "subtitle", [Chapter("First", BLOCKS), Chapter("Empty", ())])


def test_texts_are_escaped(html: str) -> None:
    assert "<h1>Title &lt;1&gt;</h1>" in html
    assert '<p class="lead">a &lt; b</p>' in html
    assert '<td class="left">k &amp; c</td><td>1.5</td>' in html


def test_chapter_without_blocks_is_omitted(html: str) -> None:
    assert ">First</h2>" in html
    assert ">Empty</h2>" not in html


def test_row_of_one_cell_spans_the_table(html: str) -> None:
    assert '<td class="group" colspan="2">group</td>' in html


def test_picture_is_data_with_its_magnified_curve_in_nanometres(html: str) -> None:
    data = re.search(r'id="pictures">(.*?)</script>', html, re.DOTALL)
    assert data is not None
    (picture,) = json.loads(data[1])
    assert picture["magnified"] == [{"trace": 0, "base": [[0.0, 0.0]] * 2, "deviation": [[1.234568, 1.234568]] * 2}]
    assert picture["factors"] == list(FACTORS)
    assert f'max="{len(FACTORS) - 1}" step="1" value="2"' in html
    assert f'<span class="picture-1-factor">{FACTORS[2]}</span>' in html


def test_page_without_pictures_has_no_script() -> None:
    assert "<script" not in page_html("t", "s", [Chapter("c", (Paragraph("p"),))])


def test_packed_page_is_smaller_and_unpacks_its_library(html: str) -> None:
    packed = page_html("Title <1>", "subtitle", [Chapter("First", BLOCKS)], packed=True)
    assert len(packed) < 0.5 * len(html)
    assert "DecompressionStream" in packed


def test_contents_lead_to_every_heading_of_a_long_page() -> None:
    chapters = [Chapter(title, (Paragraph("p"),)) for title in ("", "One", "Two & a half", "Three")]
    html = page_html("t", "s", chapters)
    links = re.findall(r'<a href="#(.*?)">(.*?)</a>', html)
    assert links == [("section-1", "One"), ("section-2", "Two &amp; a half"), ("section-3", "Three")]
    assert all(f'<h2 id="{target}">{title}</h2>' in html for target, title in links)
    assert "<nav" not in page_html("t", "s", chapters[:3])


def test_folded_blocks_are_numbered_with_the_others() -> None:
    table = TextTable(("name", "value"), (("a", "1"),), "Values.")
    html = page_html("t", "s", [Chapter("c", (Folded("more < 1", (table,)), table))])
    assert re.search(
        r"<details><summary>more &lt; 1</summary><figure class=.table.>.*Table 1\..*</details>.*Table 2\.", html, re.S
    )
