"""The campaign of coverage goes on from its folder and writes its page."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from flexros.errors import InputError
from flexros.scheduler import connected
from flexros.validation.campaigns.base import CampaignRequest
from flexros.validation.campaigns.coverage import Coverage
from flexros.validation.campaigns.coverage.settings import CoverageSettings
from tests.validation.campaigns.coverage.test_settings import DEVELOPMENT_SEED

SETTINGS = CoverageSettings(
    scenario="identify_e12", positions=2, candidates=20, repetitions=2, lanes=2, first_seed=DEVELOPMENT_SEED
)


@pytest.mark.slow
def test_campaign_goes_on_from_its_folder(tmp_path: Path) -> None:
    told: list[tuple[str, int, int]] = []

    def tell(what: str, done: int, whole: int) -> None:
        told.append((what, done, whole))

    with connected(threads=1) as client:
        first = Coverage(SETTINGS).run(CampaignRequest(tmp_path, client, None, tell))
        part = tmp_path / "group_0000_of_2.json"
        kept = part.stat().st_mtime_ns
        more = Coverage(SETTINGS).run(CampaignRequest(tmp_path, client, 3, tell))
        assert part.stat().st_mtime_ns == kept
        with pytest.raises(InputError, match="holds parts with candidates 20, but now it is 4000"):
            Coverage(CoverageSettings(scenario="identify_e12")).run(CampaignRequest(tmp_path, client))
    assert [(done, whole) for what, done, whole in told if what == "groups of repetitions"] == [
        (0, 1), (1, 1), (1, 2), (2, 2)
    ]  # fmt: skip
    assert first.record["ways"]["LLS combined"]["repetitions"] == 2
    assert json.loads(more.files["data/identification_coverage.json"])["ways"]["LLS combined"]["repetitions"] == 3
    assert "repeated 3 times" in more.files["identification_coverage.md"]
