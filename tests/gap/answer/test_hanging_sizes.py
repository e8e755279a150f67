"""Sizes at a servo without weight hang on the number that is not named."""

from __future__ import annotations

from dataclasses import replace

import pytest

from flexros.effects import RobotWithEffects
from flexros.gap.checked_log import checked_log
from flexros.gap.diagnose import diagnose
from tests.gap.diagnosis_logs import settings_of
from tests.gap.servo_logs import servo_log, servo_robot

pytestmark = pytest.mark.slow

EFFECTS = (
    "motor_inertia_error@motor_1:relative=0.4",
    "viscous_friction@motor_1:coefficient=1.0",
    "coulomb_friction@motor_1:level=0.4",
)


@pytest.mark.parametrize(("mass", "hang"), [(1e-5, True), (1.5, False)])
def test_sizes_hang_on_the_gain_of_a_servo_without_weight_alone(mass: float, hang: bool) -> None:
    model = RobotWithEffects(servo_robot(mass=mass, tolerance=0.03), ())
    logs = [servo_log(*EFFECTS, mass=mass, seed=seed) for seed in (0, 5)]
    fitted, held = (replace(checked_log(log, model.robot, name="log"), imported=True) for log in logs)
    names = tuple(one.partition("@")[0] for one in EFFECTS)
    found = diagnose(fitted, model, holdout=held, settings=settings_of(*names)).diagnosis
    assert {cause.effect for cause in found.causes if cause.probability > 0.5} == set(names)
    told = [text for text in found.warnings if "hang on" in text]
    assert ["motor_1.servo_stiffness" in text for text in told] == [True] * hang
    assert all(f"{name}@motor_1" in text for text in told for name in names)
