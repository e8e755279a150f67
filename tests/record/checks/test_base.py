"""All checks: found by themselves, each with a test, silent where all is well."""

from __future__ import annotations

from pathlib import Path

import pytest

from flexros.record.checks.base import checks

pytestmark = pytest.mark.slow

EFFECTS = [
    ("four_mass_linear", "torque_gain_error@motor_1:relative=-0.2"),
    ("four_mass_linear", "backlash@motor_1:gap=0.02"),
    ("four_mass_linear", "stiffness_error@body_1.rz:relative=-0.3"),
    ("e12", "payload_error@tool:relative=0.3"),
    ("e12", "coulomb_friction@motor_1:level=300"),
    ("elbow", "gravity_error@body_2:relative=0.3"),
]


def test_every_check_has_a_test() -> None:
    modules = {member.__module__.rpartition(".")[2] for member in checks().values()}
    tests = {path.stem.removeprefix("test_") for path in Path(__file__).parent.glob("test_*.py")}
    assert modules <= tests


@pytest.mark.parametrize("robot", ["four_mass_linear", "e12", "elbow", "emps"])
def test_healthy_log_passes_without_a_word(found, robot: str) -> None:
    assert [finding.text for finding in found(robot)] == []


@pytest.mark.parametrize(("robot", "effect"), EFFECTS)
def test_effect_of_realistic_size_is_no_problem_of_the_log(found, healthy, robot: str, effect: str) -> None:
    record = healthy(robot, (effect,))
    texts = [finding.text for finding in found(robot, record) if "is at its limit" not in finding.text]
    assert texts == []
