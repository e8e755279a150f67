"""Runs the marked commands of a page as a reader would: in one folder, with `flexros` and `python`."""

from __future__ import annotations

import os
import re
import shlex
import signal
import socket
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest

CHECKOUT = Path(__file__).parents[2]
TIMEOUT = 1500.0
PROGRAM = "import sys; from flexros.cli import main; sys.exit(main())"


def marked_blocks(text: str, marker: str) -> list[str]:
    """Give the code blocks that stand below a marker, in their order."""
    return re.findall(rf"<!-- {re.escape(marker)} -->\n```\w*\n(.*?)```", text, re.DOTALL)


def executable(path: Path, *words: str) -> None:
    path.write_text(f'#!/bin/sh\nexec {shlex.join(words)} "$@"\n', encoding="utf-8")
    path.chmod(0o755)


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def run_block(block: str, folder: Path, variables: dict[str, str], output: Path) -> int:
    """Run a block to its end, and whatever it has left behind in its process group to the end too."""
    command = ["bash", "-euxc", block]
    with output.open("wb") as file:
        process = subprocess.Popen(
            command, cwd=folder, env=variables, stdout=file, stderr=subprocess.STDOUT, start_new_session=True
        )
        try:
            return process.wait(TIMEOUT)
        finally:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()


def folder_of_reader(scratch: Path) -> tuple[Path, dict[str, str]]:
    """Make a folder with the documents, and the environment in which `flexros`, `python` ... are those of the test."""
    programs, folder = scratch / "programs", scratch / "folder"
    programs.mkdir()
    folder.mkdir()
    executable(programs / "python", sys.executable)
    executable(programs / "flexros", sys.executable, "-c", PROGRAM)
    executable(programs / "pip", sys.executable, "-m", "pip", "--disable-pip-version-check")
    executable(programs / "jupyter", sys.executable, "-m", "jupyter")
    (folder / "docs").symlink_to(CHECKOUT / "docs")
    return folder, {**os.environ, "PATH": f"{programs}{os.pathsep}{os.environ['PATH']}"}


@pytest.fixture
def run_marked(tmp_path: Path) -> Callable[[str, str], int]:
    """Return the function that runs the marked blocks of a text in one folder and returns their number."""
    folder, variables = folder_of_reader(tmp_path)
    variables |= {"DASK_PORT": str(free_port())}

    def run(text: str, marker: str) -> int:
        blocks = marked_blocks(text, marker)
        for block in blocks:
            code = run_block(block, folder, variables, tmp_path / "output")
            assert code == 0, (tmp_path / "output").read_text(encoding="utf-8", errors="replace")
        return len(blocks)

    return run
