from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest

from flexros.errors import InputError
from flexros.scheduler import connected
from flexros.validation.campaigns.base import CampaignRequest, campaign_named
from flexros.validation.campaigns.study import PaperStudy
from flexros.validation.campaigns.study.settings import StudySettings

SMALL = StudySettings("identify_e12", positions=2, candidates=30, starts=2, redrawn=2)


def test_study_is_found_by_its_name() -> None:
    assert isinstance(campaign_named("study"), PaperStudy)


@pytest.mark.slow
def test_study_goes_on_from_its_folder_with_equal_results(tmp_path: Path) -> None:
    told: list[str] = []
    with connected(threads=2) as client:
        request = CampaignRequest(tmp_path, client, progress=lambda what, done, whole: told.append(what))
        first = PaperStudy(SMALL).run(request)
        (tmp_path / "NLS15O_0_to_1.json").unlink()
        told.clear()
        again = PaperStudy(SMALL).run(request)
        with pytest.raises(InputError, match=r"holds parts with seed 1, but now it is 2"):
            PaperStudy(dataclasses.replace(SMALL, seed=2)).run(request)
    assert "samples of the experiment" not in told
    assert again.record == first.record
    assert len(first.summary) == 6
    assert "study.md" in first.files
