"""Blocks of a report as a fragment of HTML for a cell of a notebook, readable on a light and on a dark ground."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING

from flexros.report.base import Heading, Listing, Paragraph, TextTable, Tiles

if TYPE_CHECKING:
    from collections.abc import Iterable

    from flexros.report.base import Block

MOST_ROWS = 60
"""Rows of a table that a cell shows; more are counted below it (chosen)."""

_STYLE = """<style>
.flexros { font-size: 13px; line-height: 1.45; max-width: 72em; }
.flexros h4 { margin: 4px 0 2px; font-size: 15px; }
.flexros p { margin: 4px 0; }
.flexros p.note, .flexros .unit { opacity: 0.75; }
.flexros p.warning { border-left: 3px solid #b35900; padding-left: 8px; }
.flexros .tiles { display: flex; flex-wrap: wrap; gap: 6px 28px; margin: 6px 0; }
.flexros .tiles b { font-size: 17px; }
.flexros .scroll { overflow-x: auto; }
.flexros table { border-collapse: collapse; margin: 6px 0 2px; font-size: 13px; font-variant-numeric: tabular-nums; }
.flexros th, .flexros td { padding: 2px 12px 2px 0; text-align: right; vertical-align: top; background: none; }
.flexros th { border-bottom: 1px solid currentColor; }
.flexros .left { text-align: left; }
.flexros td.group { text-align: left; font-weight: 600; padding-top: 6px; }
</style>"""


def notebook_html(title: str, blocks: Iterable[Block]) -> str:
    """Return a fragment of HTML; pictures are left out, `plot` of the result draws them.

    Args:
        title: Heading; empty for none.
        blocks: Blocks of a report.
    """
    heading = f"<h4>{escape(title)}</h4>" if title else ""
    return f'<div class="flexros">{_STYLE}{heading}{"".join(map(_block, blocks))}</div>'


def _block(block: Block) -> str:
    if isinstance(block, Paragraph):
        style = f' class="{block.style}"' if block.style else ""
        return f"<p{style}>{escape(block.text)}</p>"
    if isinstance(block, Heading):
        return f"<p><b>{escape(block.text)}</b></p>"
    if isinstance(block, Listing):
        return f"<pre>{escape(block.text)}</pre>"
    if isinstance(block, Tiles):
        return f'<div class="tiles">{"".join(_tile(*item) for item in block.items)}</div>'
    return _table(block) if isinstance(block, TextTable) else ""


def _tile(name: str, value: str, unit: str, below: str) -> str:
    small = f'<br><span class="unit">{escape(below)}</span>' if below else ""
    return f'<div><span class="unit">{escape(name)}</span><br><b>{escape(value)}</b> {escape(unit)}{small}</div>'


def _table(table: TextTable) -> str:
    head = "".join(_cell("th", text, column < table.left) for column, text in enumerate(table.header))
    rows = []
    for row in table.rows[:MOST_ROWS]:
        if len(row) == 1:
            rows.append(f'<tr><td class="group" colspan="{len(table.header)}">{escape(row[0])}</td></tr>')
        else:
            rows.append(
                f"<tr>{''.join(_cell('td', text, column < table.left) for column, text in enumerate(row))}</tr>"
            )
    more = len(table.rows) - MOST_ROWS
    caption = f"{table.caption}{f' {more} more rows: to_pandas().' if more > 0 else ''}"
    below = f'<p class="note">{escape(caption)}</p>' if caption else ""
    body = f"<table><thead><tr>{head}</tr></thead><tbody>{''.join(rows)}</tbody></table>"
    return f'<div class="scroll">{body}</div>{below}'


def _cell(tag: str, text: str, left: bool) -> str:
    return f'<{tag} class="left">{escape(text)}</{tag}>' if left else f"<{tag}>{escape(text)}</{tag}>"
