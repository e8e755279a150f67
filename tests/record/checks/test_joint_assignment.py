"""Joints inverted or exchanged, which couplings and gravity show."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from flexros.record.balance.joint_assignments import JointAssignment
from flexros.record.checks.joint_assignment import JointAssignmentCheck

pytestmark = pytest.mark.slow


def test_inverted_position_of_one_joint_is_named(found, healthy, scaled) -> None:
    findings = found("e12", position=scaled(healthy("e12").position, 1, -1.0))
    assert findings[0].hopeless
    assert "torques and motions fit robot e12 far better with the position of motor_2 inverted" in findings[0].text


def test_inverted_torque_of_one_joint_is_named(found, healthy, scaled) -> None:
    findings = found("elbow", torque=scaled(healthy("elbow").torque, 0, -1.0))
    assert findings[0].hopeless
    assert "motor_1" in findings[0].text
    assert "inverted" in findings[0].text


@pytest.mark.parametrize("robot", ["e12", "elbow"])
def test_joints_exchanged_in_all_topics_are_named(found, healthy, robot: str) -> None:
    record = healthy(robot)
    findings = found(robot, position=record.position[:, ::-1], torque=record.torque[:, ::-1])
    assert findings[0].hopeless
    assert "with torque and position of motor_1 and motor_2 exchanged" in findings[0].text


def test_axis_that_counts_the_other_way_is_named(found, healthy, scaled) -> None:
    record = healthy("e12")
    findings = found("e12", position=scaled(record.position, 0, -1.0), torque=scaled(record.torque, 0, -1.0))
    assert findings[0].hopeless
    assert "with torque and position of motor_" in findings[0].text
    assert "inverted" in findings[0].text


@pytest.mark.parametrize(("prescribed", "told"), [((), 1), ((1,), 0), ((2,), 1)])
def test_an_exchange_with_a_joint_without_a_torque_that_counts_is_not_told(prescribed, told: int) -> None:
    other = JointAssignment("the position of motor_1 and motor_2 exchanged", 0.3, False, clear=False, exchanged=(0, 1))
    record, robot = SimpleNamespace(prescribed=prescribed), SimpleNamespace(name="arm")
    checked = SimpleNamespace(assignment=other, postures=(), record=record, robot=robot)
    assert len(JointAssignmentCheck().look(checked)) == told
