from __future__ import annotations

import json
from typing import TYPE_CHECKING

import numpy as np

from flexros.validation.campaigns.study.page import CAPTIONS, study_files, study_summary

if TYPE_CHECKING:
    from flexros.scenario.scenario import Scenario
    from flexros.validation.campaigns.study.jobs import Study


def test_page_pictures_and_numbers_are_made(small_study: Study, small_scenario: Scenario) -> None:
    files = study_files(small_study, small_scenario)
    assert set(files) == {"study.md", "data/study.json", *(f"figures/study_{name}.svg" for name in CAPTIONS)}
    assert "| LLS15U | " in files["study.md"]
    assert " | 80% | " in files["study.md"]
    assert "| body_3.ry.stiffness | " in files["study.md"]
    for name in files:
        assert not name.endswith(".svg") or f"({name})" in files["study.md"]
    content = json.loads(files["data/study.json"])
    np.testing.assert_allclose(content["best"], small_study.best.values)
    assert len(content["runs"]["NLS15O"]["values_over_nominal"]) == 4


def test_summary_has_a_sentence_per_estimator(small_study: Study) -> None:
    sentences = study_summary(small_study)
    assert len(sentences) == 6
    assert sentences[1].startswith("LLS15U: ")
    assert "published 80%)" in sentences[1]
