"""Scores of crowds, on answers made up by hand."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from flexros.errors import InputError
from flexros.gap.schema import Diagnosis
from flexros.validation.blind.deviation import Deviation
from flexros.validation.blind.score.answer import Answer
from flexros.validation.blind.score.crowd_truth import CrowdTruth, TrueShare, crowd_truth
from flexros.validation.blind.score.crowds import CrowdScore, crowd_score
from flexros.validation.blind.score.third_log import ThirdLog
from flexros.validation.blind.seal import OpenCase
from tests.validation.blind.cases import diagnosis, truth

COULOMB, VISCOUS, DELAY = "coulomb_friction@motor_1", "viscous_friction@motor_1", "delay@motor_2"
CROWD = truth("crowd", COULOMB, VISCOUS, DELAY)


def said(verdict: str, *causes: str, probability: float = 1.0, **other: Any) -> Diagnosis:
    """Make a diagnosis all of whose causes have one probability."""
    made = diagnosis(verdict, *causes).model_dump(by_alias=True)
    for cause in made["causes"]:
        cause["probability"] = probability
    return Diagnosis.model_validate({**made, **other})


def scored(*answers: Diagnosis | None) -> CrowdScore:
    return crowd_score([Answer(CROWD, one) for one in answers])


def test_recall_counts_effects_and_precision_names() -> None:
    found = scored(said("partly_explained", COULOMB, VISCOUS, "torque_bias@motor_2", "torque_ripple@motor_1"))
    assert (found.recall.hits, found.recall.cases) == (2, 3)
    assert (found.precision.hits, found.precision.cases) == (2, 4)
    assert found.whole.hits == 0


def test_an_improbable_cause_is_not_named() -> None:
    found = scored(said("ambiguous", COULOMB, VISCOUS, DELAY, probability=0.4))
    assert found.recall.hits == 0
    assert found.precision.cases == 0


def test_the_place_must_be_right() -> None:
    found = scored(said("explained", "coulomb_friction@motor_2"))
    assert found.recall.hits == 0
    assert (found.location.hits, found.location.cases) == (0, 1)


def test_nested_effects_are_counted_apart() -> None:
    found = scored(said("explained", "presliding_friction@motor_1", VISCOUS, DELAY))
    assert (found.recall.hits, found.recall_nested.hits) == (2, 3)
    assert (found.whole.hits, found.whole_nested.hits) == (0, 1)


def test_what_an_answer_calls_ambiguous_with_the_truth_is_counted_apart() -> None:
    lag = "actuator_lag@motor_2"
    group = [{"effect": "actuator_lag", "location": "motor_2"}, {"effect": "delay", "location": "motor_2"}]
    found = scored(said("ambiguous", COULOMB, VISCOUS, lag, ambiguity_groups=[group]))
    assert (found.recall.hits, found.recall_grouped.hits) == (2, 3)
    assert (found.precision.hits, found.precision_grouped.hits) == (2, 3)
    certain = scored(said("explained", COULOMB, VISCOUS, lag))
    assert (certain.recall_grouped.hits, certain.precision_grouped.hits) == (2, 2)


def test_a_refused_log_names_nothing() -> None:
    found = scored(None, said("explained", COULOMB, VISCOUS, DELAY))
    assert (found.recall.hits, found.recall.cases) == (3, 6)
    assert found.refused.hits == 1
    assert found.whole.hits == 1


def test_a_cause_outside_the_library_is_none_to_be_named_but_leaves_the_crowd_incomplete() -> None:
    hidden = truth("crowd", COULOMB, VISCOUS, "cable@motor_2")
    found = crowd_score([Answer(hidden, said("explained", COULOMB, VISCOUS))])
    assert (found.recall.hits, found.recall.cases) == (2, 2)
    assert found.incomplete.hits == 1
    assert found.whole.hits == 0


@pytest.mark.parametrize(
    ("verdict", "after", "over"), [("explained", 3.0, 1), ("explained", 1.1, 0), ("partly_explained", 3.0, 0)]
)
def test_explained_with_more_than_the_floor_left_is_an_over_claim(verdict: str, after: float, over: int) -> None:
    third = ThirdLog(before=50.0, after=after, closed_fraction=0.95)
    assert crowd_score([Answer(CROWD, said(verdict, COULOMB), third=third)]).over_claims.hits == over


def test_over_claims_beyond_what_the_true_effects_leave_are_counted_apart() -> None:
    third = ThirdLog(before=50.0, after=3.0, closed_fraction=0.95)
    form = CrowdTruth(third=ThirdLog(before=50.0, after=2.5, closed_fraction=0.97))
    found = crowd_score([Answer(CROWD, said("explained", COULOMB), third=third, crowd=form)])
    assert (found.over_claims.hits, found.over_truth.hits) == (1, 0)


def test_a_patch_is_held_against_the_true_effects_on_the_third_log() -> None:
    true = CrowdTruth(third=ThirdLog(before=50.0, after=2.0, closed_fraction=0.98))
    shares = (0.96, 0.90)
    thirds = [ThirdLog(before=50.0, after=3.0, closed_fraction=share) for share in shares]
    found = crowd_score([Answer(CROWD, said("explained", COULOMB), third=one, crowd=true) for one in thirds])
    assert (found.third_97.hits, found.third_97.cases) == (1, 2)
    assert found.closed_truth == pytest.approx(0.98)


def test_shares_of_the_budget_are_compared_with_the_true_ones() -> None:
    row = {"joint": "motor_1", "class": "friction", "effect": "coulomb_friction", "location": "motor_1",
           "share_first": 0.5, "share_last": 0.2, "interval": None}  # fmt: skip
    known = TrueShare(effect="coulomb_friction", location="motor_1", share_first=0.6, share_last=0.25)
    found = crowd_score([Answer(CROWD, said("explained", COULOMB, budget=[row]), crowd=CrowdTruth(budget=(known,)))])
    assert found.first_off == pytest.approx(0.1)
    assert found.last_off == pytest.approx(0.05)


def test_recall_is_counted_by_the_gain_of_an_effect() -> None:
    hidden = CROWD.model_copy(update={"gains": (60.0, 3e3, 1e6)})
    by_size = crowd_score([Answer(hidden, said("explained", VISCOUS, DELAY))]).by_size
    assert (by_size["50 to 200"].hits, by_size["50 to 200"].cases) == (0, 1)
    assert (by_size["1e3 to 1e4"].hits, by_size["1e5 and more"].hits) == (1, 1)


def test_sizes_of_right_names_are_held_against_their_intervals() -> None:
    parts = [Deviation(effect="delay", location="motor_2", parameters={"time": 1e-3}),
             Deviation(effect="torque_bias", location="motor_1", parameters={"level": 2.0})]  # fmt: skip
    hidden = CROWD.model_copy(update={"deviations": tuple(parts), "gains": (1e3, 1e3)})
    answer = said("explained", "delay@motor_2", "torque_bias@motor_1").model_dump(by_alias=True)
    for cause, name, value in zip(answer["causes"], ("time", "level"), (1.01e-3, 3.0), strict=True):
        cause["parameters"] = {name: {"value": value, "std": 0.01 * value, "unit": "s"}}
    covered = crowd_score([Answer(hidden, Diagnosis.model_validate(answer))]).covered
    assert (covered.hits, covered.cases) == (1, 2)


def test_a_third_log_that_is_refused_ends_no_campaign(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its figures are missing, and its case is counted with a failure."""

    def refuse(*_: object, name: str, **__: object) -> None:
        raise InputError(f"{name}: the torques are a multiple of what robot e12 needs")

    monkeypatch.setattr("flexros.robot.load_robot", lambda _: None)
    monkeypatch.setattr("flexros.gap.checked_log.checked_log", refuse)
    monkeypatch.setattr("flexros.logs.reader.read_log", lambda *_: None)
    case = OpenCase(name="case_0000", robot="e12", logs=("fit", "holdout", "third"), seal="")
    found = crowd_truth(tmp_path, case, CROWD)
    assert found is not None
    assert found.third is not None
    assert "a multiple of what robot e12 needs" in found.third.failure
    assert not found.budget
