"""A servo without weight: its numbers have a common factor, so that any of them may be the nominal one."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

from flexros.effects import RobotWithEffects
from flexros.gap.checked_log import checked_log
from flexros.gap.diagnose import diagnose
from flexros.gap.schema import Diagnosis
from flexros.gap.search import common_factor
from flexros.gap.settings import DiagnosisSettings
from tests.gap.diagnosis_logs import settings_of
from tests.gap.servo_logs import servo_log, servo_robot

WEIGHTLESS = 1e-3
GAIN, RUBS = "servo_stiffness_error@motor_1:relative=-0.3", "viscous_friction@motor_1:coefficient=1.5"


def diagnosed(mass: float) -> Diagnosis:
    model = RobotWithEffects(servo_robot(mass=mass), ())
    names = ("servo_stiffness_error", "viscous_friction", "motor_inertia_error", "coulomb_friction")
    logs = [servo_log(GAIN, RUBS, mass=mass, seed=seed) for seed in (0, 5)]
    fitted, held = (replace(checked_log(log, model.robot, name="log"), imported=True) for log in logs)
    return diagnose(fitted, model, holdout=held, settings=settings_of(*names)).diagnosis


@pytest.mark.slow
def test_without_weight_every_choice_of_the_nominal_number_is_told() -> None:
    found = diagnosed(WEIGHTLESS)
    assert found.verdict == "ambiguous"
    told = {one.effect for group in found.ambiguity_groups for one in group}
    assert {"servo_stiffness_error", "viscous_friction", "motor_inertia_error"} == told
    assert found.gap.closed_fraction == pytest.approx(1.0, abs=0.01)


@pytest.mark.slow
def test_gravity_fixes_the_factor() -> None:
    found = diagnosed(1.5)
    assert found.verdict == "explained"
    assert {cause.effect for cause in found.causes if cause.probability > 0.5} == {
        "servo_stiffness_error",
        "viscous_friction",
    }


STIFFNESS, TORQUE, DRAG = (
    f"{name}@motor_1" for name in ("servo_stiffness_error", "torque_gain_error", "viscous_friction")
)
ELSEWHERE = "viscous_friction@motor_2"
LEFT = {
    frozenset((STIFFNESS, TORQUE, DRAG, ELSEWHERE)): 1000.0,
    frozenset((STIFFNESS, ELSEWHERE)): 1001.0,
    frozenset((TORQUE, ELSEWHERE)): 1090.0,
    frozenset((DRAG, ELSEWHERE)): 9000.0,
}
"""Sum of squares that is left with each set of effects: a wrong stiffness alone explains the first servo."""


def _fit(names: frozenset[str]) -> Any:
    hypothesis = tuple(SimpleNamespace(name=name, location=name.split("@")[1]) for name in sorted(names))
    return SimpleNamespace(names=names, hypothesis=hypothesis, chi2=LEFT[names])


@pytest.mark.parametrize("commanded", [True, False])
def test_two_numbers_that_stand_for_nothing_together_are_left_out(
    commanded: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Either of them alone is needed beside the other; torques of a log would tell them apart."""
    monkeypatch.setattr(common_factor, "compared", lambda *_: None)
    monkeypatch.setattr(common_factor, "worth", lambda search, how, rest, fit, share: rest.chi2 > fit.chi2 + 10)
    chosen, fits = _fit(max(LEFT, key=len)), list[Any]()
    search: Any = SimpleNamespace(
        settings=DiagnosisSettings(),
        data=SimpleNamespace(record=SimpleNamespace(command=1 if commanded else None)),
        deadline=SimpleNamespace(stops=lambda: False),
        surroundings=lambda fit: SimpleNamespace(least=fit.chi2),
        removals_together=lambda fit, around, sets: [SimpleNamespace(least=LEFT[fit.names - {*one}]) for one in sets],
        without=lambda fit, *names: _fit(fit.names - {*names}),
    )
    found = common_factor._without_pairs(search, chosen, fits)
    assert found.names == ({STIFFNESS, ELSEWHERE} if commanded else chosen.names)
    assert len(fits) == commanded
