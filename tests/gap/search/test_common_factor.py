"""A servo without weight: its numbers have a common factor, so that any of them may be the nominal one."""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexros.effects import RobotWithEffects, parse_effect
from flexros.effects.friction.viscous_friction import ViscousFriction
from flexros.effects.servos import ServoDampingError, ServoStiffnessError
from flexros.gap.candidates.candidate import Candidate
from flexros.gap.checked_log import checked_log
from flexros.gap.diagnose import diagnose
from flexros.gap.prediction.predictor import Predictor
from flexros.gap.schema import Diagnosis
from flexros.gap.search import common_factor, proportion
from flexros.gap.settings import DiagnosisSettings
from tests.gap.diagnosis_logs import candidates_of, encoded, predictor_of, settings_of
from tests.gap.servo_logs import SERVO_EFFECTS, servo_log, servo_robot

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


@pytest.mark.slow
@pytest.mark.parametrize(
    ("true", "named", "imported"),
    [
        (("torque_gain_error@motor_1:relative=-0.3",), {"torque_gain_error"}, True),
        (("torque_gain_error@motor_1:relative=0.35",), {"torque_gain_error"}, True),
        (("torque_gain_error@motor_1:relative=0.35",), {"torque_gain_error"}, False),
        (("servo_stiffness_error@motor_1:relative=-0.3",), {"servo_stiffness_error"}, True),
        ((GAIN, RUBS), {"servo_stiffness_error", "viscous_friction"}, True),
        ((GAIN, RUBS), {"servo_stiffness_error", "viscous_friction"}, False),
    ],
)
def test_a_wrong_torque_constant_is_told_from_a_wrong_stiffness(
    true: tuple[str, ...], named: set[str], imported: bool
) -> None:
    model = RobotWithEffects(servo_robot(tolerance=0.03), ())
    logs = [servo_log("coulomb_friction@motor_1:level=0.3", *true, seed=seed) for seed in (0, 5)]
    fitted, held = (replace(checked_log(log, model.robot, name="log"), imported=imported) for log in logs)
    names = [name for name in SERVO_EFFECTS if name != "gravity_error"]  # the weight fixes the common factor
    found = diagnose(fitted, model, holdout=held, settings=settings_of(*names)).diagnosis
    causes = {cause.effect: cause for cause in found.causes if cause.probability > 0.5}
    assert set(causes) == {"coulomb_friction", *named}
    for text in true:
        wanted = parse_effect(text, "test").effect
        sizes = causes[wanted.name].parameters
        assert {name: one.value for name, one in sizes.items()} == pytest.approx(
            wanted.model_dump(include={*sizes}), rel=0.1
        )


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
    monkeypatch.setattr(common_factor, "_without_gains", lambda search, chosen, fits: chosen)
    monkeypatch.setattr(common_factor, "_with_one_gain", lambda search, chosen, fits: chosen)
    monkeypatch.setattr(common_factor, "_with_friction", lambda search, chosen, fits: chosen)
    monkeypatch.setattr(common_factor, "_rivals", lambda search, chosen: [])
    chosen, fits = _fit(max(LEFT, key=len)), list[Any]()
    search: Any = SimpleNamespace(
        settings=DiagnosisSettings(),
        data=SimpleNamespace(record=SimpleNamespace(command=1 if commanded else None)),
        deadline=SimpleNamespace(stops=lambda: False),
        surroundings=lambda fit: SimpleNamespace(least=fit.chi2),
        removals_together=lambda fit, around, sets: [SimpleNamespace(least=LEFT[fit.names - {*one}]) for one in sets],
        without=lambda fit, *names: _fit(fit.names - {*names}),
    )
    found = common_factor.with_other_scales(search, chosen, fits)
    assert found.names == ({STIFFNESS, ELSEWHERE} if commanded else chosen.names)
    assert len(fits) == commanded


@dataclass(frozen=True)
class _Sized:
    """A fit, of which a part of the attributes counts."""

    hypothesis: tuple[Candidate, ...]
    theta: np.ndarray
    predictor: Predictor


def test_friction_and_inertia_in_proportion_to_a_gain() -> None:
    """Of half the torque, half of all that a motor meets explains the same motion; shares and shapes stay."""
    sizes = {
        "coulomb_friction": {"level": 0.5},
        "viscous_friction": {"coefficient": 0.01, "asymmetry": 0.4},
        "motor_inertia_error": {"relative": -0.4},
        "load_dependent_friction": {"share": 0.1},
        "torque_gain_error": {"relative": -0.5},
    }
    every = {name.split("@")[0]: one for name, one in candidates_of().items()}
    hypothesis = tuple(every[name] for name in sizes)
    predictor = predictor_of(*hypothesis)
    theta = np.concatenate([encoded(one, **sizes[one.effect.name]) for one in hypothesis])
    fit: Any = _Sized(hypothesis, theta, predictor)
    scaled = proportion.in_proportion(fit, every["torque_gain_error"])
    found = {one.effect.name: own for one, own in zip(hypothesis, predictor.values(scaled.theta), strict=True)}
    nominal = predictor.robot.parameters["motor_1.viscous_friction"].value
    assert found["coulomb_friction"]["level"] == pytest.approx(1.0)
    assert found["viscous_friction"] == pytest.approx({"coefficient": 2 * (nominal + 0.01) - nominal, "asymmetry": 0.4})
    assert found["motor_inertia_error"]["relative"] == pytest.approx(0.2)
    assert found["load_dependent_friction"]["share"] == pytest.approx(0.1)


@pytest.mark.parametrize("alike", [True, False])
def test_a_gain_is_left_out_where_other_friction_explains_as_much(alike: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    gain = candidates_of()["torque_gain_error@motor_1"]
    other = candidates_of()["coulomb_friction@motor_1"]
    chosen: Any = SimpleNamespace(hypothesis=(gain, other), names={gain.name, other.name}, chi2=1000.0)
    rest = SimpleNamespace(hypothesis=(other,), chi2=1001.0 if alike else 1100.0)
    monkeypatch.setattr(common_factor, "compared", lambda *_: None)
    monkeypatch.setattr(common_factor, "in_proportion", lambda fit, gain: fit)
    monkeypatch.setattr(common_factor, "reduced", lambda search, fit, fits, removed: fit)
    monkeypatch.setattr(common_factor, "worth", lambda search, how, rest, fit, share: rest.chi2 > fit.chi2 + 10)
    search: Any = SimpleNamespace(
        settings=DiagnosisSettings(),
        data=SimpleNamespace(record=SimpleNamespace(command=1)),
        deadline=SimpleNamespace(stops=lambda: False),
        without=lambda fit, name: rest,
    )
    assert common_factor._without_gains(search, chosen, []) is (rest if alike else chosen)


def test_of_two_gains_the_second_may_go_with_the_first(monkeypatch: pytest.MonkeyPatch) -> None:
    first = candidates_of()["torque_gain_error@motor_1"]
    second, other = replace(first, location="motor_2"), candidates_of()["coulomb_friction@motor_1"]
    chosen: Any = SimpleNamespace(hypothesis=(first, second, other), chi2=1000.0)
    rest: Any = SimpleNamespace(hypothesis=(second, other), chi2=1001.0)
    least: Any = SimpleNamespace(hypothesis=(other, replace(other, location="motor_2")), chi2=1002.0)
    monkeypatch.setattr(common_factor, "compared", lambda *_: None)
    monkeypatch.setattr(common_factor, "in_proportion", lambda fit, gain: fit.hypothesis.index(gain))
    monkeypatch.setattr(common_factor, "reduced", lambda search, fit, fits, removed: least)
    monkeypatch.setattr(common_factor, "worth", lambda *_: False)
    search: Any = SimpleNamespace(
        settings=DiagnosisSettings(), deadline=SimpleNamespace(stops=lambda: False), without=lambda fit, name: rest
    )
    assert common_factor._without_gains(search, chosen, []) is least


@pytest.mark.parametrize("named", [True, False])
def test_the_damping_of_a_gain_is_its_own_error_or_friction_without_one(named: bool) -> None:
    """Beside a late command both may be named: the friction stays, and goes later if it is needless."""
    sizes: dict[Any, dict[str, float]] = {
        ServoStiffnessError: {"relative": -0.2},
        ViscousFriction: {"coefficient": 0.1},
        **({ServoDampingError: {"relative": -0.3}} if named else {}),
    }
    predictor = SimpleNamespace(
        values=lambda theta: list(sizes.values()),
        robot=SimpleNamespace(parameters={"motor_1.servo_damping": SimpleNamespace(value=2.0)}),
        tolerance=SimpleNamespace(names=("motor_1.servo_stiffness",), logarithms=lambda deviations: [np.log(0.9)]),
    )
    hypothesis = tuple(SimpleNamespace(effect=effect, location="motor_1") for effect in sizes)
    fit: Any = SimpleNamespace(hypothesis=hypothesis, predictor=predictor, theta=(), deviations=())
    found = common_factor._stiffness_and_damping(fit, "motor_1")
    assert found is not None
    (_, of_stiffness), (damping, of_damping) = found
    assert damping.effect is (ServoDampingError if named else ViscousFriction)
    assert of_stiffness == pytest.approx(0.9 * 0.8 - 1)
    assert of_damping == pytest.approx(-0.3 if named else 0.05)


def test_exchanges_that_the_time_leaves_out_are_no_rivals(monkeypatch: pytest.MonkeyPatch) -> None:
    addition = SimpleNamespace(candidate=candidates_of()["coulomb_friction@motor_1"])
    monkeypatch.setattr(common_factor, "_exchanges", lambda search, chosen: [("torque_gain_error@motor_1", addition)])
    search: Any = SimpleNamespace(
        deadline=SimpleNamespace(stops=lambda: False), parallel=lambda step, work, items, needed=0: []
    )
    chosen: Any = SimpleNamespace(names=frozenset({"torque_gain_error@motor_1"}), chi2=1.0)
    assert common_factor._rivals(search, chosen) == []
