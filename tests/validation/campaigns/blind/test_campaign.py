"""The campaign of the blind check: parts, page, pictures."""

from __future__ import annotations

from pathlib import Path
from typing import Any
from xml.etree import ElementTree as Xml

import pytest

from flexros.errors import InputError
from flexros.gap.result import DiagnosisResult
from flexros.random_streams import Stream
from flexros.scheduler import connected
from flexros.validation.blind import diagnose_case as blind_run
from flexros.validation.blind.make_case import MakeSettings
from flexros.validation.blind.plan import Case, PlanSettings
from flexros.validation.blind.score.answer import Answer
from flexros.validation.blind.seal import sha256
from flexros.validation.campaigns.base import CampaignRequest
from flexros.validation.campaigns.blind.campaign import BlindCheck
from flexros.validation.campaigns.blind.case_part import answer_of, case_part
from flexros.validation.campaigns.blind.settings import BlindSettings
from flexros.validation.campaigns.blind_campaign import ScoredCases
from tests.validation.blind.cases import answer, diagnosis, truth

pytestmark = pytest.mark.slow

MADE = MakeSettings(11, Stream.BLIND_DEVELOPMENT, (4.0, 4.0, 4.0))
NULL = Case(1, "null", "four_mass_linear", (), "none", "exact", False)
FRICTION, DELAY = "coulomb_friction@motor_1", "delay@motor_2"


class Answered:
    """Stand-in for the result of a diagnosis."""

    diagnosis = diagnosis("no_gap")
    patch = ()


def answers() -> list[Answer]:
    return [
        answer(truth("single", FRICTION), diagnosis("explained", FRICTION)),
        answer(truth("single", DELAY), diagnosis("explained", FRICTION)),
        answer(truth("single", DELAY, gain=25.0), diagnosis("no_gap")),
        answer(truth("null"), diagnosis("no_gap")),
    ]


def test_page_holds_figures_pictures_and_what_is_left() -> None:
    failures = {"case_0009": "Traceback\nValueError: no"}
    result = BlindCheck().result(ScoredCases(answers(), failures, 100, {"commit": "abc"}))
    page = result.files["blind.md"]
    assert "4 of 100 planned cases" in page
    assert "| right effect first (top-1) | 50.0 % (9.5 to 90.5), 1 of 2 |" in page
    assert "- case_0009: ValueError: no" in page
    assert "The other 96 cases take about 0.3 h" in result.summary[-1]
    for name in ("confusion", "detection", "calibration"):
        assert f"blind_{name}.svg" in page
        Xml.fromstring(result.files[f"figures/blind_{name}.svg"])
    assert len(result.record["cases"]) == 4
    assert "salt" not in result.record["cases"][0]


def test_confusion_matrix_has_a_cell_for_every_truth_and_answer() -> None:
    picture = BlindCheck().result(ScoredCases(answers(), {}, 4, {})).files["figures/blind_confusion.svg"]
    assert picture.count("<rect") == 1 + 3 * 4  # background; three truths, one effect that was said and three others


def test_part_is_sealed_and_keeps_no_logs(monkeypatch: pytest.MonkeyPatch) -> None:
    def diagnosed(folder: Path, case: object) -> DiagnosisResult:
        return Answered()  # type: ignore[return-value]

    monkeypatch.setattr(blind_run, "diagnosed", diagnosed)
    part = case_part(MADE, NULL)
    assert answer_of("case_0001", part).truth.kind == "null"
    assert not answer_of("case_0001", part).alarm
    with pytest.raises(InputError, match="the truth of case_0001 does not have the SHA-256"):
        answer_of("case_0001", {**part, "truth": part["truth"].replace("null", "pair")})


def test_fault_of_a_diagnosis_is_told_and_the_case_counts_as_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(folder: Path, case: object) -> DiagnosisResult:
        raise ZeroDivisionError("of the diagnosis")

    monkeypatch.setattr(blind_run, "diagnosed", fail)
    part = case_part(MADE, NULL)
    assert part["failure"].endswith("ZeroDivisionError: of the diagnosis\n")
    assert answer_of("case_0001", part).diagnosis is None


def sealed_null(settings: MakeSettings, case: Case) -> dict[str, Any]:
    """Give a case without logs and without answer."""
    del settings
    text = truth("null", name=case.name).model_dump_json()
    return {
        "seal": sha256(text),
        "truth": text,
        "diagnosis": None,
        "failure": None,
        "seconds": None,
        "oracle": None,
        "third": None,
    }


def test_larger_number_of_cases_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("flexros.validation.campaigns.blind.case_part.case_part", sealed_null)
    check = BlindCheck(BlindSettings(plan=PlanSettings(per_size=0, nulls=3, unknowns=0, pairs=0)))
    with connected(threads=1) as client:
        check.run(CampaignRequest(tmp_path, client, 1))
        first = (tmp_path / "case_0000.json").stat().st_mtime_ns
        result = check.run(CampaignRequest(tmp_path, client, 2))
    assert (tmp_path / "case_0000.json").stat().st_mtime_ns == first
    assert result.record["planned"] == 3
    assert len(result.record["cases"]) == 2
    assert "2 of 3 planned cases" in result.files["blind.md"]
