"""Hook of mkdocs: runs the notebooks and puts them on pages with their outputs.

The notebooks are kept without outputs; a build of the pages runs each once. Pictures are drawn by the plotting library
of the site itself, so that the pages work offline.
"""

from __future__ import annotations

import hashlib
import json
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mkdocs.structure.files import File
from plotly.offline import get_plotlyjs
from run_notebook import PICTURE, TABLE, executed

if TYPE_CHECKING:
    from collections.abc import Iterator

FOLDER = "notebooks"
LIBRARY = "plotly.min.js"
_LONG = 30
"""Lines of a text output that are shown (chosen)."""
_pages: dict[str, str] = {}
"""Pages by the fingerprint of their notebook: a server builds again and again."""


def on_files(files: Any, config: Any) -> Any:
    """Add a page for each notebook, and the plotting library."""
    notebooks = sorted(Path(config["docs_dir"], FOLDER).glob("*.ipynb"))
    for path in notebooks:
        files.append(File.generated(config, f"{FOLDER}/{path.stem}.md", content=page_of(path)))
    if notebooks:
        files.append(File.generated(config, f"{FOLDER}/{LIBRARY}", content=get_plotlyjs()))
    return files


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Let the overview link the pages, where the checkout links the notebooks."""
    return markdown.replace(".ipynb)", ".md)") if page.file.src_uri == f"{FOLDER}/overview.md" else markdown


def page_of(path: Path) -> str:
    """Run a notebook and return its page as Markdown.

    Args:
        path: The notebook.
    """
    name = hashlib.sha256(path.read_bytes()).hexdigest()
    if name not in _pages:
        notebook = executed(path)
        _pages[name] = "\n\n".join(_blocks(notebook, path.name))
    return _pages[name]


def _blocks(notebook: Any, name: str) -> Iterator[str]:
    """Yield the cells with their outputs; the first text cell has the heading."""
    yield f'<script src="../{LIBRARY}"></script>\n<style>.modebar-container {{ display: none; }}</style>'
    pictures = 0
    for number, cell in enumerate(notebook.cells):
        if cell.cell_type == "markdown":
            yield cell.source
        else:
            yield f"```python\n{cell.source}\n```"
            for output in cell.outputs:
                yield _output(output, f"picture-{pictures}")
                pictures += 1
        if number == 0:
            yield f"[Download the notebook]({name}){{ .md-button }}"


def _output(output: Any, name: str) -> str:
    data = output.get("data", {})
    if PICTURE in data:
        return _picture(data[PICTURE], name)
    if TABLE in data:
        rows = (line.strip() for line in data[TABLE].splitlines())
        return f'<div class="output" style="overflow-x: auto">{" ".join(filter(None, rows))}</div>'
    lines = (data.get("text/plain") or output.get("text", "")).splitlines()
    more = [f"... {len(lines) - _LONG} more lines"] if len(lines) > _LONG else []
    return f'<pre class="output">{escape(chr(10).join([*lines[:_LONG], *more]))}</pre>'


def _picture(figure: Any, name: str) -> str:
    """Return an element with the script that draws a picture into it."""
    text = json.dumps({"data": figure["data"], "layout": figure["layout"]}, separators=(",", ":"))
    text = text.replace("<", "\\u003c")  # a "</script" inside would end the script early
    height = figure["layout"].get("height", 450)
    draw = f'Plotly.newPlot("{name}",{text},{{"responsive":true,"displayModeBar":false}})'
    return f'<div id="{name}" style="height: {height}px"></div>\n<script>{draw}</script>'
