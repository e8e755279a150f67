"""Scores of answers whose figures are known."""

from __future__ import annotations

import pytest

from flexros.json_text import json_text
from flexros.validation.blind.score.answer import Answer
from flexros.validation.blind.score.score import confusion, record, score, scores_by
from tests.validation.blind.cases import answer, diagnosis, truth

FRICTION, BRISTLES = "coulomb_friction@motor_1", "presliding_friction@motor_1"
DELAY, LAG = "delay@motor_2", "actuator_lag@motor_2"


@pytest.fixture
def answers() -> list[Answer]:
    return [
        answer(truth("single", FRICTION), diagnosis("explained", FRICTION, LAG)),
        answer(truth("single", FRICTION), diagnosis("explained", BRISTLES)),
        answer(truth("single", DELAY), diagnosis("ambiguous", LAG, DELAY, probability=0.6, groups=((LAG, DELAY),))),
        answer(truth("single", DELAY), diagnosis("explained", "delay@motor_1")),
        answer(truth("single", LAG, gain=20.0), diagnosis("no_gap")),
        answer(truth("single", LAG, nuisance="tolerance_1"), diagnosis("unknown_effect")),
        answer(truth("null"), diagnosis("no_gap")),
        answer(truth("null"), diagnosis("explained", FRICTION)),
        answer(truth("unknown", "cable@motor_1"), diagnosis("unknown_effect", FRICTION, probability=0.2)),
        answer(truth("pair", FRICTION, DELAY), diagnosis("explained", DELAY, BRISTLES)),
        answer(truth("null"), None),
    ]


def test_single_effects_well_above_the_noise(answers: list[Answer]) -> None:
    found = score(answers)
    assert (found.top_1.hits, found.top_1.cases) == (2, 5)
    assert found.top_1_nested.hits == 3
    assert found.top_3.hits == 3
    assert found.in_group.hits == 3
    assert (found.location.hits, found.location.cases) == (2, 3)
    assert found.detected.hits == 5
    assert found.group_size == pytest.approx((2 + 4) / 5)


def test_alarms_unknown_causes_and_pairs(answers: list[Answer]) -> None:
    found = score(answers)
    assert (found.false_alarms.hits, found.false_alarms.cases) == (1, 3)
    assert (found.unknown_found.hits, found.unknown_found.cases) == (1, 1)
    assert (found.known_unknown.hits, found.known_unknown.cases) == (1, 6)
    assert (found.pairs.hits, found.pairs_nested.hits, found.pairs.cases) == (0, 1, 1)
    assert found.refused.hits == 1


def test_calibration_is_of_the_first_cause_wherever_one_is_claimed(answers: list[Answer]) -> None:
    found = score(answers).calibration
    assert found is not None
    assert sum(found.count) == 7
    assert sum(share * n for share, n in zip(found.true, found.count, strict=True)) == pytest.approx(4)


def test_weak_effects_count_in_the_detection_curve_only(answers: list[Answer]) -> None:
    found = score(answers)
    assert found.detection.cases == 6
    assert 20 < found.detection.centre < 1000


def test_confusion_matrix(answers: list[Answer]) -> None:
    table = confusion(answers)
    assert table["coulomb_friction"] == {"coulomb_friction": 1, "presliding_friction": 1}
    assert table["nothing"] == {"no gap": 1, "coulomb_friction": 1, "refused": 1}
    assert table["cable"] == {"unknown": 1}


def test_one_motor_has_no_difference_between_all_and_itself() -> None:
    said = diagnosis("explained", "delay@all")
    one = answer(truth("single", "delay@motor_1", robot="four_mass"), said)
    two = answer(truth("single", "delay@motor_1", robot="e12"), said)
    assert one.named(1, placed=True)
    assert not two.named(1, placed=True)


def test_scores_by_state_of_the_model_and_as_json(answers: list[Answer]) -> None:
    assert {name: one.cases for name, one in scores_by(answers, "nuisance").items()} == {"exact": 10, "tolerance_1": 1}
    assert '"confusion"' in json_text(record(answers))
