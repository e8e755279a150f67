"""What the README tells a user to type."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from pathlib import Path

CHECKOUT = Path(__file__).parents[2]
README = (CHECKOUT / "README.md").read_text(encoding="utf-8")
RUN = re.compile(r"<!-- run by tests/contracts/test_readme.py -->\n```\n(.*?)```", re.DOTALL)


def test_marked_commands_run(tmp_path: Path) -> None:
    blocks = RUN.findall(README)
    assert blocks
    program = "import sys; from flexros.cli import main; sys.exit(main())"
    flexros = f'flexros() {{ {shlex.quote(sys.executable)} -c {shlex.quote(program)} "$@"; }}\n'
    for block in blocks:
        command = ["bash", "-euxc", flexros + block]
        run = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert run.returncode == 0, run.stderr
    assert (tmp_path / "circle.html").stat().st_size > 10_000


def test_make_targets_exist() -> None:
    targets = set(re.findall(r"(?:^|`)make (\w+)", README, re.MULTILINE))
    known = set(re.findall(r"^(\w+):", (CHECKOUT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
    assert {"demo", "test", "lint", "bench"} <= targets <= known


def test_named_paths_exist() -> None:
    paths = {name for name in re.findall(r"`([\w./]+/[\w./]+)`", README) if not name.startswith(("install/", ".venv/"))}
    assert paths
    assert [name for name in sorted(paths) if not (CHECKOUT / name).exists()] == []
