"""The reference is what the models say: files, commands and topics."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

import flexros

pytestmark = pytest.mark.slow

DOCS = Path(__file__).parents[2] / "docs"
WRITTEN = "<!-- written by docs/generate/reference_pages.py -->"
REFERENCE = DOCS / "reference"
PAGES = [
    str(path.relative_to(REFERENCE))
    for path in sorted(REFERENCE.rglob("*.md"))
    if path.read_text(encoding="utf-8").startswith(WRITTEN)
] + [str(path.relative_to(REFERENCE)) for path in sorted(REFERENCE.rglob("*.schema.json"))]


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Write the pages anew into a folder."""
    folder = tmp_path_factory.mktemp("reference")
    environment = {**os.environ, "PYTHONPATH": str(DOCS.parent)}
    script = str(DOCS / "generate" / "reference_pages.py")
    subprocess.run([sys.executable, script, str(folder)], check=True, env=environment)
    return folder


def test_all_pages_are_committed(written: Path) -> None:
    assert {str(path.relative_to(written)) for path in written.rglob("*.*")} == set(PAGES)


def test_every_name_of_the_front_door_has_a_page() -> None:
    assert {Path(page).stem.removesuffix("_class") for page in PAGES if page.startswith("python/")} == {
        "index",
        *flexros.__all__,
    }


@pytest.mark.parametrize("page", PAGES)
def test_page_is_what_the_models_say(page: str, written: Path) -> None:
    committed = (REFERENCE / page).read_text(encoding="utf-8")
    assert (written / page).read_text(encoding="utf-8") == committed, "run python docs/generate/reference_pages.py"
