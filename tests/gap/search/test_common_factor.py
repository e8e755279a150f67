"""A servo without weight: its numbers have a common factor, so that any of them may be the nominal one."""

from __future__ import annotations

from dataclasses import replace

import pytest

from flexros.effects import RobotWithEffects
from flexros.gap.checked_log import checked_log
from flexros.gap.diagnose import diagnose
from flexros.gap.schema import Diagnosis
from tests.gap.diagnosis_logs import settings_of
from tests.gap.servo_logs import servo_log, servo_robot

pytestmark = pytest.mark.slow

WEIGHTLESS = 1e-3
GAIN, RUBS = "servo_stiffness_error@motor_1:relative=-0.3", "viscous_friction@motor_1:coefficient=1.5"


def diagnosed(mass: float) -> Diagnosis:
    model = RobotWithEffects(servo_robot(mass=mass), ())
    names = ("servo_stiffness_error", "viscous_friction", "motor_inertia_error", "coulomb_friction")
    logs = [servo_log(GAIN, RUBS, mass=mass, seed=seed) for seed in (0, 5)]
    fitted, held = (replace(checked_log(log, model.robot, name="log"), imported=True) for log in logs)
    return diagnose(fitted, model, holdout=held, settings=settings_of(*names)).diagnosis


def test_without_weight_every_choice_of_the_nominal_number_is_told() -> None:
    found = diagnosed(WEIGHTLESS)
    assert found.verdict == "ambiguous"
    told = {one.effect for group in found.ambiguity_groups for one in group}
    assert {"servo_stiffness_error", "viscous_friction", "motor_inertia_error"} == told
    assert found.gap.closed_fraction == pytest.approx(1.0, abs=0.01)


def test_gravity_fixes_the_factor() -> None:
    found = diagnosed(1.5)
    assert found.verdict == "explained"
    assert {cause.effect for cause in found.causes if cause.probability > 0.5} == {
        "servo_stiffness_error",
        "viscous_friction",
    }
