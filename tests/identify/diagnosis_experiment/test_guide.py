"""The page of the guide names every part, key and experiment, and its picture is drawn by its script."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from flexros.gap.next_experiment.catalogue import CATALOGUE
from flexros.identify.diagnosis_experiment.specification import WEIGHTS, DiagnosisSpecification

EXPLANATION = Path(__file__).parents[3] / "docs" / "explanation"
PAGE = (EXPLANATION / "diagnosis_experiment.md").read_text(encoding="utf-8")


def test_every_part_has_a_row_with_its_time() -> None:
    for name, weight in WEIGHTS.items():
        assert f"| {name} | {weight:g} |" in PAGE


def test_every_key_is_explained() -> None:
    assert all(f"`{key}`" in PAGE for key in DiagnosisSpecification.model_fields)


def test_every_experiment_of_the_catalogue_is_listed() -> None:
    assert all(f"| `{entry.name}` |" in PAGE for entry in CATALOGUE)


@pytest.mark.slow
def test_picture_of_the_page_is_drawn_by_its_script(tmp_path: Path) -> None:
    script = EXPLANATION.parent / "generate" / "diagnosis_experiment_pictures.py"
    here = {**os.environ, "PYTHONPATH": str(EXPLANATION.parents[1])}
    subprocess.run([sys.executable, str(script), str(tmp_path)], check=True, env=here)
    assert "](diagnosis_course.svg)" in PAGE
    drawn, committed = (
        (folder / "diagnosis_course.svg").read_text(encoding="utf-8") for folder in (tmp_path, EXPLANATION)
    )
    assert drawn.count("<polyline") == committed.count("<polyline") > 10
