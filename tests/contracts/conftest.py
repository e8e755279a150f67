"""How commands that a page marks are run, as its reader would: in one folder, with `flexros` and `python`."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

CHECKOUT = Path(__file__).parents[2]
PROGRAM = "import sys; from flexros.cli import main; sys.exit(main())"


def marked_blocks(text: str, marker: str) -> list[str]:
    """Give the code blocks that stand below a marker, in their order."""
    return re.findall(rf"<!-- {re.escape(marker)} -->\n```\w*\n(.*?)```", text, re.DOTALL)


def executable(path: Path, *words: str) -> None:
    path.write_text(f'#!/bin/sh\nexec {shlex.join(words)} "$@"\n', encoding="utf-8")
    path.chmod(0o755)


@pytest.fixture
def run_marked(tmp_path: Path) -> Callable[[str, str], int]:
    """Give what runs the blocks of a text below a marker, all in one folder; it tells how many there are."""
    programs, folder = tmp_path / "programs", tmp_path / "folder"
    programs.mkdir()
    folder.mkdir()
    executable(programs / "python", sys.executable)
    executable(programs / "flexros", sys.executable, "-c", PROGRAM)
    (folder / "docs").symlink_to(CHECKOUT / "docs")
    variables = {**os.environ, "PATH": f"{programs}{os.pathsep}{os.environ['PATH']}"}

    def run(text: str, marker: str) -> int:
        blocks = marked_blocks(text, marker)
        for block in blocks:
            command = ["bash", "-euxc", block]
            done = subprocess.run(command, cwd=folder, env=variables, capture_output=True, text=True, check=False)
            assert done.returncode == 0, done.stdout + done.stderr
        return len(blocks)

    return run
