"""The campaign of nulls with rounded encoders: its plan, its page and its figures."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from flexros.random_streams import Stream
from flexros.scheduler import connected
from flexros.validation.blind.make_case import MakeSettings
from flexros.validation.blind.plan import Case, PlanSettings
from flexros.validation.blind.score.answer import Answer
from flexros.validation.blind.seal import sha256
from flexros.validation.campaigns.base import CampaignRequest
from flexros.validation.campaigns.blind_campaign import ScoredCases
from flexros.validation.campaigns.quantized_nulls.campaign import QuantizedNulls
from flexros.validation.campaigns.quantized_nulls.settings import QuantizedNullsSettings
from tests.gap.diagnosis_logs import settings_of
from tests.validation.blind.cases import answer, diagnosis, truth


def null(name: str, verdict: str | None, *causes: str, step: float = 0.2, **other: str) -> Answer:
    hidden = truth("null", name=name, **other).model_copy(update={"conditions": {"encoder_step": step}})
    return answer(hidden, None if verdict is None else diagnosis(verdict, *causes))


def page_of(*answers: Answer, **failures: str) -> str:
    found = ScoredCases(answers, failures, 400, {"commit": "abc"})
    return QuantizedNulls().result(found).files["quantized_nulls.md"]


def test_plan_holds_nulls_of_every_robot_half_of_them_with_a_wrong_nominal_model() -> None:
    plan = QuantizedNulls().plan()
    assert {one.kind for one in plan} == {"null"}
    assert {one.robot for one in plan} == {"four_mass_linear", "four_mass", "elbow", "e12", "rigid_six_axis"}
    wrong = [one.nuisance for one in plan if one.nuisance != "exact"]
    assert set(wrong) == {"tolerance_3"}
    assert len(wrong) == pytest.approx(len(plan) / 2, abs=2)


def test_cases_are_those_of_the_evaluation_stream_and_their_encoders_round() -> None:
    made = QuantizedNulls().make_settings()
    assert made.stream == Stream.BLIND_EVALUATION
    assert made.encoder_steps == (0.1, 1.0)


def test_page_counts_false_alarms_by_robot_and_nominal_model_and_says_what_was_named() -> None:
    page = page_of(
        null("case_0000", "no_gap", robot="e12"),
        null("case_0001", "no_gap", robot="elbow", nuisance="tolerance_3"),
        null("case_0002", "explained", "delay@motor_2", robot="elbow", nuisance="tolerance_3", step=0.71),
    )
    assert "`flexros campaign quantized_nulls --repetitions 3`" in page
    assert (
        "**Called anything but `no_gap`: 33.3 % (6.1 to 79.2), 1 of 3; goal at most 1 %.** The goal is missed" in page
    )
    assert "| all | 33.3 % (6.1 to 79.2), 1 of 3 | 2.000 | 10.0 |" in page
    assert "| nominal exact | 0.0 % (0.0 to 79.3), 0 of 1 |" in page
    assert "| nominal 3 % off | 50.0 % (9.5 to 90.5), 1 of 2 |" in page
    assert "| e12 | 0.0 % (0.0 to 79.3), 0 of 1 |" in page
    assert "| elbow | 50.0 % (9.5 to 90.5), 1 of 2 |" in page
    assert "| step from 0.3 of the noise | 100.0 % (20.7 to 100.0), 1 of 1 |" in page
    conditions = "elbow | nominal 3 % off | random, 0.5 ms | 0.00 | 0.71"
    assert f"| case_0002 | {conditions} | explained | 2.000 | delay motor_2 0.90 |  |" in page
    assert "case_0001" not in page
    assert "Versions: commit abc." in page


def test_page_says_which_false_alarms_do_not_come_from_the_rounding() -> None:
    answers = [null(f"case_{k:04d}", "explained", "delay@motor_2") for k in range(2)]
    controls = {
        "case_0000": null("case_0000", "no_gap", step=0.0),
        "case_0001": null("case_0001", "ambiguous", "backlash@motor_1", step=0.0),
    }
    result = QuantizedNulls().result(ScoredCases(answers, {}, 400, {}, controls))
    page = result.files["quantized_nulls.md"]
    assert [row["verdict"] for row in result.record["controls"]] == ["no_gap", "ambiguous"]
    assert "Without rounding 1 of the 2 are called so as well" in page
    assert "| delay motor_2 0.90 | no_gap |" in page
    assert "| delay motor_2 0.90 | ambiguous, backlash motor_1 0.90 |" in page


def test_page_without_false_alarm_says_how_far_the_interval_reaches() -> None:
    page = page_of(*(null(f"case_{k:04d}", "no_gap") for k in range(30)))
    assert "0.0 % (0.0 to 11.4), 0 of 30; goal at most 1 %.** The share meets the goal" in page
    assert "the interval reaches 11.4 %" in page
    assert "## False alarms\n\nNone.\n" in page


def test_refused_log_counts_as_no_right_answer() -> None:
    page = page_of(null("case_0003", "no_gap"), null("case_0004", None), case_0004="Traceback\nValueError: no")
    assert "1 of 2; goal at most 1 %.** 1 of these logs was refused." in page
    assert "| refused |" in page
    assert "- case_0004: ValueError: no" in page


def test_record_holds_shares_and_every_case() -> None:
    found = ScoredCases([null("case_0002", "explained", "delay@motor_2", step=0.71)], {}, 400, {"commit": "abc"})
    result = QuantizedNulls().result(found)
    assert "data/quantized_nulls.json" in result.files
    assert result.record["scores"]["all"]["hits"] == 1
    assert result.record["scores"]["e12"]["cases"] == 1
    (row,) = result.record["cases"]
    assert row["causes"] == [["delay", "motor_2", 0.9]]
    assert row["conditions"]["encoder_step"] == 0.71
    assert "salt" not in row
    assert "1 of 400 planned nulls" in result.summary[0]


def sealed_null(settings: MakeSettings, case: Case) -> dict[str, Any]:
    """Give a case without logs: a false alarm in every second one, where encoders round."""
    text = truth("null", name=case.name).model_dump_json()
    alarm = settings.encoder_steps is not None and case.number % 2 == 1
    said = (diagnosis("explained", "delay@motor_2") if alarm else diagnosis("no_gap")).model_dump_json(by_alias=True)
    rest = dict.fromkeys(("failure", "seconds", "oracle", "third", "crowd"))
    return {"seal": sha256(text), "truth": text, "diagnosis": said, **rest}


def settings(nulls: int) -> QuantizedNullsSettings:
    plan = PlanSettings(
        robots={"four_mass_linear": 1.0}, per_size=0, nulls=nulls, unknowns=0, pairs=0, nuisance=0.5
    )  # fmt: skip
    return QuantizedNullsSettings(7, Stream.BLIND_DEVELOPMENT, plan, durations=(4.0, 4.0, 1.0))


@pytest.mark.slow
def test_larger_number_of_cases_goes_on_and_false_alarms_are_made_again_without_rounding(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("flexros.validation.campaigns.blind.case_part.case_part", sealed_null)
    check = QuantizedNulls(settings(3))
    with connected(threads=1) as client:
        check.run(CampaignRequest(tmp_path, client, 1))
        first = (tmp_path / "case_0000.json").stat().st_mtime_ns
        result = check.run(CampaignRequest(tmp_path, client, 2))
    assert (tmp_path / "case_0000.json").stat().st_mtime_ns == first
    assert len(result.record["cases"]) == 2
    assert [path.name for path in tmp_path.glob("*_smooth.json")] == ["case_0001_smooth.json"]
    assert "Without rounding 0 of the 1 are called so as well" in result.files["quantized_nulls.md"]


@pytest.mark.slow
def test_a_short_log_gives_a_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    few = settings_of("coulomb_friction", "backlash")
    monkeypatch.setattr("flexros.validation.blind.diagnose_case.case_settings", lambda: few)
    with connected(threads=1) as client:
        result = QuantizedNulls(settings(1)).run(CampaignRequest(tmp_path, client))
    page = result.files["quantized_nulls.md"]
    assert "of 1; goal at most 1 %" in page
    assert "| four_mass_linear |" in page
    assert result.record["failures"] == {}
    (row,) = result.record["cases"]
    assert 0.1 <= row["conditions"]["encoder_step"] <= 1.0
    assert row["verdict"] is not None
