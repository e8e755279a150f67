from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.study.page import CAPTIONS, write_study

if TYPE_CHECKING:
    from flexros.config.scenario import Scenario
    from flexros.identify.study.campaign import Study


def test_page_pictures_and_numbers_are_written(small_study: Study, small_scenario: Scenario, tmp_path: Path) -> None:
    write_study(small_study, small_scenario, tmp_path)
    files = {path.name for path in tmp_path.iterdir()}
    assert files == {"study.md", "study.json", *(f"study_{name}.svg" for name in CAPTIONS)}
    text = (tmp_path / "study.md").read_text(encoding="utf-8")
    assert "| LLS15U | " in text
    assert " | 80% | " in text
    assert "body_3.ry.stiffness" in text
    content = json.loads((tmp_path / "study.json").read_text(encoding="utf-8"))
    np.testing.assert_allclose(content["best"], small_study.best.values)
    assert len(content["runs"]["NLS15O"]["values_over_nominal"]) == 6


def test_folder_that_is_not_there_is_refused(small_study: Study, small_scenario: Scenario, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"the study cannot be written to '.*nowhere': no such folder; make it"):
        write_study(small_study, small_scenario, tmp_path / "nowhere")
