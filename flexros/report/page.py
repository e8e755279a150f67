"""Assembly of the blocks of sections to one self-contained HTML page."""

from __future__ import annotations

import base64
import gzip
import json
from dataclasses import dataclass
from functools import cache
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np
from plotly.offline import get_plotlyjs

from flexros.report.base import FACTORS, Folded, Heading, Listing, Paragraph, Picture, TextTable, Tiles
from flexros.report.style import SCRIPT, STYLE, UNPACK

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.report.base import Block, MovingLine


_LONG_NAME = 24
"""Characters from which a name may be divided at its underscores and slashes (chosen)."""
_LONG_TEXT = 40
"""Characters from which a cell of text gets a wide column, beside which a narrow screen scrolls (chosen)."""
_FEWEST_CONTENTS = 3
"""Headings from which a page has a column of contents (chosen)."""
_PANEL_WIDTH = 110
"""Least width of one of many panels side by side [px]; a narrow screen scrolls across them (chosen)."""


@dataclass(frozen=True)
class Chapter:
    """Heading and content of one section; no heading where the title is empty."""

    title: str
    blocks: tuple[Block, ...]


class Page:
    """Collects chapters and numbers their pictures and tables."""

    def __init__(self, title: str, subtitle: str) -> None:
        self._title = title
        self._subtitle = subtitle
        self._body: list[str] = []
        self._titles: list[str] = []
        self._pictures: list[dict[str, Any]] = []
        self._tables = 0

    def add(self, chapter: Chapter) -> None:
        """Append a chapter; one without blocks is omitted."""
        if not chapter.blocks:
            return
        heading = ""
        if chapter.title:
            self._titles.append(chapter.title)
            heading = f'<h2 id="section-{len(self._titles)}">{escape(chapter.title)}</h2>'
        self._body.append(f"<section>{heading}{''.join(map(self._block, chapter.blocks))}</section>")

    def html(self, packed: bool = False) -> str:
        """Return the whole page.

        Args:
            packed: Whether the plotting library is compressed, for a page of 2 MB less that needs a browser of 2023.
        """
        # A "</script" or "<!--" inside the data would end the script element early.
        data = json.dumps(self._pictures, separators=(",", ":")).replace("<", "\\u003c")
        drawing = f'<script type="application/json" id="pictures">{data}</script>{_scripts(packed)}'
        return (
            '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
            '<meta name="viewport" content="width=device-width, initial-scale=1">'
            f'<link rel="icon" href="data:,"><title>{escape(self._title)}</title>'
            f"<style>{STYLE}</style></head>\n<body>{self._contents()}<main>"
            f"<header><p>FlexROS</p><h1>{escape(self._title)}</h1><p>{escape(self._subtitle)}</p></header>"
            "<noscript><p>The pictures of this report need JavaScript; the tables do not.</p></noscript>\n"
            f"{chr(10).join(self._body)}\n</main>\n{drawing if self._pictures else ''}</body></html>\n"
        )

    def _contents(self) -> str:
        """Return the column of contents; nothing on a short page."""
        if len(self._titles) < _FEWEST_CONTENTS:
            return ""
        links = (f'<a href="#section-{row}">{escape(title)}</a>' for row, title in enumerate(self._titles, start=1))
        return f'<nav aria-label="Contents"><b>Contents</b>{"".join(links)}</nav>'

    def _block(self, block: Block) -> str:
        if isinstance(block, Folded):
            inner = "".join(map(self._block, block.blocks))
            return f"<details><summary>{escape(block.summary)}</summary>{inner}</details>"
        if isinstance(block, Paragraph):
            style = f' class="{block.style}"' if block.style else ""
            return f"<p{style}>{_kept(block.text)}</p>"
        if isinstance(block, Heading):
            return f"<h3>{escape(block.text)}</h3>"
        if isinstance(block, Listing):
            return _listing(block)
        if isinstance(block, Tiles):
            return f'<div class="tiles">{"".join(_tile(*item) for item in block.items)}</div>'
        if isinstance(block, TextTable):
            return self._table(block)
        return self._picture(block)

    def _table(self, table: TextTable) -> str:
        self._tables += 1
        head = "".join(_cell("th", text, column < table.left) for column, text in enumerate(table.header))
        rows = []
        for row in table.rows:
            if len(row) == 1:
                rows.append(f'<tr><td class="group" colspan="{len(table.header)}">{escape(row[0])}</td></tr>')
            else:
                cells = "".join(_cell("td", text, column < table.left) for column, text in enumerate(row))
                rows.append(f"<tr>{cells}</tr>")
        return (
            f'<figure class="table"><figcaption><b>Table {self._tables}.</b> {escape(table.caption)}</figcaption>'
            f'<div class="scroll"><table><thead><tr>{head}</tr></thead><tbody>{"".join(rows)}</tbody></table></div>'
            "</figure>"
        )

    def _picture(self, picture: Picture) -> str:
        name = f"picture-{len(self._pictures) + 1}"
        curves = [
            {"trace": curve.trace, "base": _digits(curve.base), "deviation": _digits(curve.deviation)}
            for curve in picture.magnified
        ]
        figure = json.loads(picture.figure.to_json())
        entry = {"id": name, "figure": figure, "magnified": curves, "factors": FACTORS}
        if picture.moving is not None:
            entry["moving"] = _moving(picture.moving)
        self._pictures.append(entry)
        factor = f'<span class="{name}-factor">{picture.factor}</span>'
        caption = escape(picture.caption).replace("{factor}", factor)
        slider = ""
        if picture.moving is not None:
            last = len(picture.moving.time) - 1
            slider = (
                f'<div class="magnifier"><button type="button" id="{name}-play">Play</button>'
                f'<input id="{name}-time" aria-label="Time" type="range" min="0" max="{last}" step="1" value="0">'
                f'<output id="{name}-now"></output></div>'
            )
        if curves or picture.moving is not None:
            what = "deflection" if picture.moving is not None else "error"
            slider += (
                f'<div class="magnifier"><label for="{name}-slider">Magnification of the {what}</label>'
                f'<input id="{name}-slider" type="range" min="0" max="{len(FACTORS) - 1}" step="1" '
                f'value="{FACTORS.index(picture.factor)}"><output class="{name}-factor">{picture.factor}</output></div>'
            )
        height = picture.figure.layout.height
        return (
            f'<figure>{slider}<div class="scroll"><div class="picture" id="{name}" '
            f'style="height:{height}px{_least_width(figure["layout"])}"></div></div>'
            f"<figcaption><b>Figure {len(self._pictures)}.</b> {caption}</figcaption></figure>"
        )


def page_html(title: str, subtitle: str, chapters: Sequence[Chapter], *, packed: bool = False) -> str:
    """Return a page with the given chapters.

    Args:
        title: Heading of the page.
        subtitle: One line below it.
        chapters: The chapters in order.
        packed: Whether the plotting library is compressed, as for `Page.html`.

    Returns:
        The HTML text, complete in itself.
    """
    page = Page(title, subtitle)
    for chapter in chapters:
        page.add(chapter)
    return page.html(packed)


def _scripts(packed: bool) -> str:
    """Return the plotting library and the drawing script."""
    if not packed:
        return f"<script>{get_plotlyjs()}</script><script>{SCRIPT}</script>"
    return f'<script type="text/plain" id="library">{_packed_library()}</script><script>{UNPACK}</script>'


@cache
def _packed_library() -> str:
    return base64.b64encode(gzip.compress(get_plotlyjs().encode(), mtime=0)).decode()


def _tile(name: str, value: str, unit: str, below: str) -> str:
    return (
        f'<div class="tile"><div class="name">{escape(name)}</div>'
        f'<div class="value">{escape(value)}<small>{escape(unit)}</small></div>'
        f'<div class="below">{_kept(below)}</div></div>'
    )


def _listing(listing: Listing) -> str:
    """Return a text with a button that copies it; without a clipboard the text is selected instead."""
    copy = (
        "const p=this.nextElementSibling,s=getSelection();s.selectAllChildren(p);"
        "if(navigator.clipboard)navigator.clipboard.writeText(p.textContent).then(()=>{this.textContent='copied'})"
    )
    return (
        f'<figure class="listing"><button type="button" onclick="{copy}">copy</button>'
        f"<pre>{escape(listing.text)}</pre><figcaption>{escape(listing.caption)}</figcaption></figure>"
    )


def _kept(text: str) -> str:
    """Escape a text, with numbers that stay on the line of their per cent sign."""
    return escape(text).replace(" %", "\u00a0%")


def _cell(tag: str, text: str, left: bool) -> str:
    if not left:
        return f"<{tag}>{_kept(text)}</{tag}>"
    shown = _kept(text)
    if len(text) > _LONG_NAME and " " not in text:
        shown = shown.replace("_", "_<wbr>").replace("/", "/<wbr>")
    kind = "left"
    if tag == "td" and len(text) > _LONG_TEXT:
        kind = "left long" if " " in text else "left value"
    return f'<{tag} class="{kind}">{shown}</{tag}>'


def _least_width(layout: dict[str, Any]) -> str:
    """Return the least width of a picture of more than two panels side by side; others are arranged by the script."""
    starts = {axis.get("domain", [0])[0] for name, axis in layout.items() if name.startswith("xaxis")}
    return f";min-width:{_PANEL_WIDTH * len(starts)}px" if len(starts) > 2 else ""


def _moving(line: MovingLine) -> dict[str, Any]:
    """Return a moving line with a resolution of 0.1 mm, its deviation of a micrometre."""
    return {
        "trace": line.trace,
        "time": np.round(line.time, 4).tolist(),
        "base": np.round(line.base, 4).tolist(),
        "deviation": np.round(line.deviation, 6).tolist(),
    }


def _digits(points: FloatArray) -> list[list[float]]:
    """Return points [mm] with a resolution of a nanometre, so that the page stays small."""
    rounded: list[list[float]] = np.round(points, 6).tolist()
    return rounded
