"""The page of the guide: its program runs, its pictures are those of its script."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

EXPLANATION = Path(__file__).parents[3] / "docs" / "explanation"
PAGE = (EXPLANATION / "frequency_response.md").read_text(encoding="utf-8")


def test_program_of_the_page_runs() -> None:
    program = re.search(r"```python\n(.*?)```", PAGE, re.DOTALL)
    assert program is not None
    names: dict[str, object] = {}
    exec(compile(program[1], "frequency_response.md", "exec"), names)
    assert len(names["responses"]) == 3  # type: ignore[arg-type]


def test_pictures_of_the_page_are_drawn_by_its_script(tmp_path: Path) -> None:
    script = EXPLANATION.parent / "generate" / "frequency_response_pictures.py"
    here = {**os.environ, "PYTHONPATH": str(EXPLANATION.parents[1])}
    subprocess.run([sys.executable, str(script), str(tmp_path)], check=True, env=here)
    drawn = {path.name for path in tmp_path.iterdir()}
    assert drawn == set(re.findall(r"\]\((frf_\w+\.svg)\)", PAGE))
    for name in drawn:
        committed = (EXPLANATION / name).read_text(encoding="utf-8")
        assert (tmp_path / name).read_text(encoding="utf-8").count("<polyline") == committed.count("<polyline")
