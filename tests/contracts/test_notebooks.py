"""The notebooks of the guide run, and are kept without outputs."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import nbformat
import pytest

DOCS = Path(__file__).parents[2] / "docs"
NOTEBOOKS = sorted((DOCS / "notebooks").glob("*.ipynb"))


def test_there_are_four() -> None:
    assert [path.stem for path in NOTEBOOKS] == [
        "design_a_controller",
        "diagnose_a_log",
        "identify",
        "run_and_analyse",
    ]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_no_outputs_are_kept(path: Path) -> None:
    """Outputs would go stale, and hide changes of the text."""
    cells = [cell for cell in nbformat.read(path, 4).cells if cell.cell_type == "code"]
    assert cells
    assert all(not cell.outputs and cell.execution_count is None for cell in cells)


@pytest.mark.guide
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_runs_and_shows_tables_and_pictures(path: Path) -> None:
    script = str(DOCS / "generate" / "run_notebook.py")
    ran = subprocess.run([sys.executable, script, str(path)], capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr
