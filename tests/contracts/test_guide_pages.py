"""The guide as pages: what mkdocs.yml names; `make docs` in .ci/run builds them strictly."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
from ruamel.yaml import YAML

from flexros.gap.diagnosis_task import NOMINAL_MODEL
from flexros.gap.progress import BEGINS
from flexros.gap.schema import ANSWERED, NEXT_EXPERIMENT

CHECKOUT = Path(__file__).parents[2]
DOCS = CHECKOUT / "docs"
ROOMS = sorted(path.name for path in (CHECKOUT / "flexros").iterdir() if any(path.glob("[!_]*.py")))
WITHOUT_REFERENCE = {"cli": "reference/commands.md"}


def pages(entry: Any) -> list[str]:
    """List the files of a part of the navigation."""
    if isinstance(entry, str):
        return [entry]
    parts = entry.values() if isinstance(entry, dict) else entry
    return [page for part in parts for page in pages(part)]


@pytest.fixture(scope="module")
def navigation() -> list[str]:
    content = YAML(typ="safe").load((CHECKOUT / "mkdocs.yml").read_text(encoding="utf-8"))
    return pages(content["nav"])


def test_pages_exist_and_stand_there_once(navigation: list[str]) -> None:
    made = {f"notebooks/{path.stem}.md" for path in DOCS.glob("notebooks/*.ipynb")}  # by docs/generate/notebook_hook.py
    assert [page for page in navigation if not (DOCS / page).is_file() and page not in made] == []
    assert made <= set(navigation)
    assert len(navigation) == len(set(navigation))


def test_results_and_decisions_are_there(navigation: list[str]) -> None:
    written = {
        f"{path.parent.name}/{path.name}" for room in ("results", "decisions") for path in DOCS.glob(f"{room}/*.md")
    }
    assert written - set(navigation) == set()


def test_every_room_has_its_reference(navigation: list[str]) -> None:
    assert {page for page in navigation if page.startswith("reference/api/")} == {
        f"reference/api/{room}.md" for room in (*ROOMS, "nodes", "validation") if room not in WITHOUT_REFERENCE
    }


def links_of(page: str) -> set[str]:
    """List the pages that a page links to, relative to the guide."""
    text = (DOCS / page).read_text(encoding="utf-8")
    targets = (target.partition("#")[0] for target in re.findall(r"\]\(([^)\s]+)\)", text))
    folder = (DOCS / page).parent
    return {str((folder / t).resolve().relative_to(DOCS)) for t in targets if t.endswith(".md") and "://" not in t}


def test_every_result_is_linked_from_the_overview() -> None:
    written = {f"results/{path.name}" for path in DOCS.glob("results/*.md")} - {"results/index.md"}
    assert written - links_of("results/index.md") == set()


def test_the_first_page_leads_to_the_three_ways_in_and_on() -> None:
    wanted = {"tutorials/first_run.md", "tutorials/identification.md", "tutorials/ur5e.md", "tutorials/own_log.md"}
    wanted |= {"gallery.md", "explanation/comparison.md", "results/index.md"}
    assert wanted - links_of("index.md") == set()


def test_pictures_of_the_gallery_exist() -> None:
    text = (DOCS / "gallery.md").read_text(encoding="utf-8")
    pictures = re.findall(r"!\[[^\]]*\]\(([^)]+)\)", text)
    assert len(pictures) >= 6
    assert [name for name in pictures if not (DOCS / name).is_file()] == []


def test_what_a_partial_answer_lacks_is_said_of_every_step_of_a_search() -> None:
    """A diagnosis had ended in a step that the guide did not know."""
    page = (DOCS / "how-to" / "limit_a_diagnosis.md").read_text(encoding="utf-8")
    assert [step for step in (NOMINAL_MODEL, *BEGINS, ANSWERED, NEXT_EXPERIMENT) if f"`{step}`" not in page] == []
