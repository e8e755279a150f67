"""Joints that an imported robot counts the other way round than its own file, and a log as that file."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from flexros.record.joint_signs import joints_not_turned, sign_words
from flexros.record.read import read_record
from flexros.robot import Robot, load_robot, robot_from_data
from tests.gap.servo_logs import servo_log, servo_robot

COLUMN = {"column": "q", "quantity": "position", "unit": "rad"}


def with_tag(robot: Robot, sign: str = "-1") -> Robot:
    tags = {"motor_1.joint": "lift", "motor_1.joint_sign": sign}
    return robot_from_data(robot.spec.model_copy(update={"tags": tags}).model_dump(), robot.name)


def imported(mapping: Any) -> dict[str, Any]:
    return {"import": {"mapping": mapping}}


@pytest.mark.parametrize(
    ("column", "names"),
    [
        ({}, ("lift (motor_1)",)),
        ({"sign": -1}, ()),
        ({"unit": "count", "scale": {"value": -1e-3, "unit": "rad/count"}}, ()),
        ({"sign": -1, "unit": "count", "scale": {"value": -1e-3, "unit": "rad/count"}}, ("lift (motor_1)",)),
    ],
)
def test_joints_whose_columns_are_not_turned_are_listed(column: dict[str, Any], names: tuple[str, ...]) -> None:
    log = replace(servo_log(), provenance=imported({"name": "recorder", "columns": [COLUMN | column]}))
    assert joints_not_turned(log, with_tag(servo_robot())) == names
    assert joints_not_turned(log, with_tag(servo_robot(), "1")) == ()


@pytest.mark.parametrize("provenance", [{}, {"import": 3}, imported(None), imported({"name": "recorder"})])
def test_without_a_mapping_none_are(provenance: dict[str, Any]) -> None:
    assert joints_not_turned(replace(servo_log(), provenance=provenance), with_tag(load_robot("elbow"))) == ()


def test_a_record_has_them_and_says_what_to_do() -> None:
    log = replace(servo_log(), provenance=imported({"name": "recorder", "columns": [COLUMN]}))
    record = read_record(log, with_tag(servo_robot()), name="log", positions=True)
    (text,) = sign_words(record, record)
    assert text.startswith("the robot file counts lift (motor_1) the other way round")
    assert "sign: -1" in text
    assert sign_words(replace(record, not_turned=())) == ()
