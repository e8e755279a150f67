"""Run a notebook of the guide, which must show a table and a picture and print nothing: python run_notebook.py FILE."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from typing import Any

import nbformat
from nbclient import NotebookClient

PICTURE, TABLE = "application/vnd.plotly.v1+json", "text/html"
"""Kinds of outputs."""
LONGEST = 300
"""Time after which a cell counts as hung [s] (chosen)."""


def executed(path: Path) -> Any:
    """Return a notebook with its outputs.

    Args:
        path: The notebook, which stays as it is.

    Raises:
        ValueError: It shows no table or no picture, or prints text or an error beside them.
    """
    notebook = nbformat.read(path, 4)
    with tempfile.TemporaryDirectory(prefix="flexros_") as folder:
        where = {"metadata": {"path": folder}}
        NotebookClient(notebook, timeout=LONGEST, resources=where, extra_arguments=["--log-level=ERROR"]).execute()
    outputs = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]
    missing = {TABLE, PICTURE} - {kind for output in outputs for kind in output.get("data", {})}
    if missing:
        raise ValueError(f"{path.name} shows nothing of the kind {', '.join(sorted(missing))}")
    if any(output.output_type in ("stream", "error") for output in outputs):
        raise ValueError(f"{path.name} prints text or an error beside its tables and pictures")
    return notebook


if __name__ == "__main__":
    executed(Path(sys.argv[1]))
