"""The page of the effects: written from the classes, with a section and a picture for each."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from flexros.effects import effects

pytestmark = pytest.mark.slow

REFERENCE = Path(__file__).parents[2] / "docs" / "reference"
PAGE = (REFERENCE / "effects.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Write page and pictures anew into a folder."""
    folder = tmp_path_factory.mktemp("guide")
    here = {**os.environ, "PYTHONPATH": str(REFERENCE.parents[1])}
    subprocess.run(
        [sys.executable, str(REFERENCE.parent / "generate" / "effects_page.py"), str(folder)], check=True, env=here
    )
    return folder


def test_page_is_what_the_classes_say(written: Path) -> None:
    assert (written / "effects.md").read_text(encoding="utf-8") == PAGE, "run python docs/generate/effects_page.py"


def test_every_effect_has_a_section_and_a_picture(written: Path) -> None:
    assert sorted(re.findall(r"^### (\w+)$", PAGE, re.MULTILINE)) == sorted(effects())
    assert sorted(re.findall(r"\]\(pictures/effects/(\w+)\.svg\)", PAGE)) == sorted(effects())
    committed = {path.name for path in (REFERENCE / "pictures" / "effects").iterdir()}
    assert committed == {path.name for path in (written / "pictures" / "effects").iterdir()}
    assert committed == {f"{name}.svg" for name in effects()}


@pytest.mark.parametrize("name", sorted(effects()))
def test_an_effect_is_switched_off_by_parameters_of_its_own(name: str) -> None:
    section = PAGE.partition(f"\n### {name}\n")[2].partition("\n### ")[0]
    off = re.findall(r"`(\w+)` = 0", re.search(r"^Switched off by (.*)\.$", section, re.MULTILINE)[1])  # type: ignore[index]
    assert off
    assert set(off) <= set(effects()[name].model_fields)


@pytest.mark.parametrize("name", sorted(effects()))
def test_picture_is_drawn_by_the_script(name: str, written: Path) -> None:
    here, anew = (
        (folder / "pictures" / "effects" / f"{name}.svg").read_text(encoding="utf-8") for folder in (REFERENCE, written)
    )
    lines = re.findall(r'<polyline points="([^"]*)"', anew)
    assert here.count("<polyline") == len(lines) >= 1
    assert all("nan" not in line and len(set(line.split())) > 1 for line in lines)


@pytest.mark.parametrize("name", sorted(effects()))
def test_every_effect_has_a_fingerprint(name: str) -> None:
    kind = effects()[name]
    assert len(kind.fingerprint) > 40
    assert not kind.fingerprint.endswith(".")
    assert kind.__doc__


def test_program_of_the_page_runs(capsys: pytest.CaptureFixture[str]) -> None:
    program = re.search(r"```python\n(.*?)```", PAGE, re.DOTALL)
    assert program is not None
    exec(compile(program[1], "effects.md", "exec"), {})
    assert capsys.readouterr().out == "e12 ['backlash@motor_1']\n"
