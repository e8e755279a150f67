"""The sensitivity study on one case and one setting."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from distributed import Client

from flexros.errors import InputError
from flexros.scheduler import connected
from flexros.validation.campaigns.base import CampaignRequest
from flexros.validation.campaigns.sensitivity import Sensitivity, case_part
from flexros.validation.campaigns.sensitivity.settings import CASES, SensitivitySettings
from tests.gap.diagnosis_logs import settings_of


@pytest.fixture(scope="module")
def client() -> Iterator[Client]:
    with connected(threads=1) as made:
        yield made


@pytest.mark.slow
def test_a_case_is_diagnosed_with_the_default_and_with_each_factor(
    client: Client, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    few = settings_of("coulomb_friction", "viscous_friction", "backlash")
    monkeypatch.setattr(case_part, "case_settings", lambda: few)
    settings = SensitivitySettings(cases=CASES[2:4], durations=(4.0, 3.0, 1.0), keys=("level",))
    result = Sensitivity(settings).run(CampaignRequest(tmp_path, client, repetitions=1))
    answers = result.record["answers"]
    assert list(answers) == ["case_0003"]
    assert [len(answers["case_0003"][key]) for key in ("", "level")] == [1, 2]
    assert answers["case_0003"][""][0]["cause"] == "coulomb_friction"
    assert all("verdict" in answer for answer in answers["case_0003"]["level"])
    assert "| `level` | 0.0002 | 2 |" in result.files["sensitivity.md"]


def test_an_unknown_setting_is_refused(client: Client, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="unknown setting of the diagnosis 'levl'.*did you mean 'level'"):
        Sensitivity(SensitivitySettings(keys=("levl",))).run(CampaignRequest(tmp_path, client))
