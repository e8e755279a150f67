"""The campaign of crowds: its page and its figures."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from flexros.scheduler import connected
from flexros.validation.blind.make_case import MakeSettings, UndrawnCaseError
from flexros.validation.blind.plan import Case, PlanSettings
from flexros.validation.blind.score.answer import Answer
from flexros.validation.blind.seal import sha256
from flexros.validation.campaigns.base import CampaignRequest
from flexros.validation.campaigns.blind_campaign import ScoredCases
from flexros.validation.campaigns.crowds.campaign import BlindCrowds
from flexros.validation.campaigns.crowds.settings import CrowdSettings
from tests.validation.blind.cases import diagnosis, truth

FRICTION, BIAS, DELAY = "coulomb_friction@motor_1", "torque_bias@motor_1", "delay@motor_2"


def test_page_and_figures_hold_shares_goals_and_every_case() -> None:
    crowd = truth("crowd", FRICTION, BIAS, DELAY, name="case_0007")
    answers = [Answer(crowd, diagnosis("explained", FRICTION, "torque_ripple@motor_1", probability=0.5), 12.0)]
    failures = {"case_0009": "Traceback\nUndrawnCaseError: no"}
    result = BlindCrowds().result(ScoredCases(answers, failures, 60, {"commit": "abc"}))
    page = result.files["crowds.md"]
    assert "the first 2 of 60 planned cases (case_0009 could not be drawn)" in page
    assert "33.3 % (6.1 to 79.2), 1 of 3 (goal 95 %)" in page
    assert "| case_0007 | e12 | exact | explained | coulomb_friction@motor_1 1e+03 |" in page
    assert "- case_0009: UndrawnCaseError: no" in page
    assert result.record["scores"]["nominal exact"]["recall"]["hits"] == 1
    assert result.record["cases"][0]["causes"][0]["effect"] == "coulomb_friction"
    assert "salt" not in result.record["cases"][0]
    assert "data/crowds.json" in result.files


def sealed_crowd(settings: MakeSettings, case: Case) -> dict[str, Any]:
    """Give a crowd without logs and without answer."""
    del settings
    text = truth("crowd", *(f"{e}@{at}" for e, at in zip(case.effects, case.places)), name=case.name).model_dump_json()
    rest = dict.fromkeys(("diagnosis", "failure", "seconds", "oracle", "third", "crowd"))
    return {"seal": sha256(text), "truth": text, **rest}


def test_a_case_that_cannot_be_drawn_is_told_and_ends_no_campaign(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def unstable(case: Case, *_: object) -> None:
        raise UndrawnCaseError(f"{case.name} was drawn 20 times and its loop was never stable")

    monkeypatch.setattr("flexros.validation.campaigns.blind.case_part.make_case", unstable)
    plan = PlanSettings(per_size=0, nulls=0, unknowns=0, pairs=0, crowds=2, crowd_robots={"elbow": 1.0})
    with connected(threads=1) as client:
        result = BlindCrowds(CrowdSettings(plan=plan)).run(CampaignRequest(tmp_path, client, 2))
    assert result.record["cases"] == []
    assert "- case_0001: case_0001 was drawn 20 times and its loop was never stable" in result.files["crowds.md"]


@pytest.mark.slow
def test_larger_number_of_cases_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("flexros.validation.campaigns.blind.case_part.case_part", sealed_crowd)
    plan = PlanSettings(per_size=0, nulls=0, unknowns=0, pairs=0, crowds=3, crowd_robots={"elbow": 1.0})
    check = BlindCrowds(CrowdSettings(plan=plan))
    with connected(threads=1) as client:
        check.run(CampaignRequest(tmp_path, client, 1))
        first = (tmp_path / "case_0000.json").stat().st_mtime_ns
        result = check.run(CampaignRequest(tmp_path, client, 2))
    assert (tmp_path / "case_0000.json").stat().st_mtime_ns == first
    assert len(result.record["cases"]) == 2
