"""Targets, paths and picture of the README; its commands are run by test_first_hour.py."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

CHECKOUT = Path(__file__).parents[2]
README = (CHECKOUT / "README.md").read_text(encoding="utf-8")


def test_make_targets_exist() -> None:
    targets = set(re.findall(r"(?:^|`)make ([\w-]+)", README, re.MULTILINE))
    known = set(re.findall(r"^([\w-]+):", (CHECKOUT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
    assert {"demo", "test", "lint", "docs"} <= targets <= known


def test_named_paths_exist() -> None:
    paths = {name for name in re.findall(r"`([\w./]+/[\w./]+)`", README) if not name.startswith(("install/", ".venv/"))}
    assert paths
    assert [name for name in sorted(paths) if not (CHECKOUT / name).exists()] == []


@pytest.mark.slow
def test_picture_is_drawn_by_its_script(tmp_path: Path) -> None:
    script = CHECKOUT / "docs" / "generate" / "readme_picture.py"
    environment = {**os.environ, "PYTHONPATH": str(CHECKOUT)}
    few = ("coulomb_friction", "viscous_friction")
    subprocess.run([sys.executable, str(script), str(tmp_path), *few], check=True, env=environment)
    committed = CHECKOUT / "docs" / "pictures" / "overview.svg"
    assert "](docs/pictures/overview.svg)" in README
    drawn, kept = (path.read_text(encoding="utf-8") for path in (tmp_path / "overview.svg", committed))
    assert drawn.count("<polyline") == kept.count("<polyline") == 5


def test_is_short() -> None:
    assert len(README.splitlines()) <= 105
