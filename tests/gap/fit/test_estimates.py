"""Fitted parameters in the units of their effects, with their covariance."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from flexros.effects import RobotWithEffects, effects
from flexros.effects.friction.friction_over_position import FrictionOverPosition
from flexros.effects.kinds.curve import AbstractCurve
from flexros.effects.torque_curve import TorqueCurve
from flexros.gap.candidates.candidate import Candidate, free_parameter
from flexros.gap.diagnose import diagnose
from flexros.gap.fit.candidate_fit import CandidateFit
from flexros.gap.fit.estimates import (
    beyond_search,
    clearness,
    covariance_of,
    parameters_of,
    placed_effects,
    unit_of_parameter,
)
from flexros.gap.fit.initial_values import initial_values
from flexros.gap.fit.least_squares import fit
from flexros.gap.fit.sum_of_squares import chi2_of
from flexros.gap.schema import CauseParameter
from flexros.gap.settings import FitSettings
from flexros.robot import load_robot
from tests.gap.diagnosis_logs import candidates_of, data_of, encoded, predictor_of, settings_of
from tests.gap.rigid_arm import COULOMB, arm, record_of_arm

pytestmark = pytest.mark.slow

LEVEL = 0.03


def test_an_effect_is_as_clear_as_its_clearest_size_that_the_log_determines() -> None:
    sizes = [(0.3, 0.1, True), (-2.0, 0.5, True), (9.0, 1.0, False)]
    made = [CauseParameter(value=value, std=std, unit="1", determined=told) for value, std, told in sizes]
    assert clearness(made) == pytest.approx(4.0)
    assert clearness(made[2:]) == 0.0


def test_effects_have_their_numbers(fitted: CandidateFit) -> None:
    assert [(str(one).partition(":")[0]) for one in placed_effects(fitted)] == [
        "coulomb_friction@motor_1",
        "stiffness_error@body_2.rz",
    ]
    (friction, soft) = parameters_of(fitted)
    assert friction["level"].value == pytest.approx(0.05)
    assert (friction["level"].unit, soft["relative"].unit) == ("Nm", "1")
    assert soft["relative"].value == pytest.approx(-0.1)


@pytest.mark.parametrize(
    ("curve", "size", "finding"), [(FrictionOverPosition, "level_2", True), (TorqueCurve, "torque_2", False)]
)
def test_a_law_at_a_limit_is_a_value_of_the_curve_that_extends_it(
    curve: type[AbstractCurve], size: str, finding: bool
) -> None:
    """Left out of the patch of a leg, it had left negative friction there."""
    friction = candidates_of()["coulomb_friction@motor_1"]
    beside = Candidate(curve, "motor_1", (replace(friction.free[0], name=size, signed=True),))
    theta = np.array([*encoded(friction, level=friction.free[0].high), 0.0])
    found = beyond_search(CandidateFit(predictor_of(friction, beside), theta, 0.0))
    assert found == (set() if finding else {friction.name})


def test_deviations_are_in_the_units_of_the_numbers(fitted: CandidateFit) -> None:
    friction, soft = parameters_of(fitted)
    assert friction["level"].std == pytest.approx(0.1 * 0.05)
    assert soft["relative"].std == pytest.approx(0.02)


def test_a_size_below_its_deviation_is_not_determined(fitted: CandidateFit) -> None:
    scale = np.diag(1 / np.square([1.1, 1e-4, 1.0]))
    friction, soft = parameters_of(replace(fitted, information=scale))
    assert not friction["level"].determined
    assert soft["relative"].determined


def test_a_size_that_seems_exact_is_that_of_a_fit_that_diverged(fitted: CandidateFit) -> None:
    """On an arm with one joint without a usable torque a load was known to 33 digits."""
    friction, soft = parameters_of(replace(fitted, information=np.diag([1e66, 1e4, 1.0])))
    assert not friction["level"].determined
    assert soft["relative"].determined


@pytest.mark.parametrize(("phase", "written"), [(0.0, 0.0), (-5.466, 0.817)])
def test_a_phase_is_known_as_well_at_zero_and_written_within_half_a_turn(phase: float, written: float) -> None:
    ranges = effects()["torque_ripple"].ranges
    free = tuple(free_parameter(name, ranges[name], 1.0) for name in ("amplitude", "phase"))
    ripple = Candidate(effects()["torque_ripple"], "motor_1", free, (("order", 6.0),))
    theta = np.array(encoded(ripple, amplitude=0.1, phase=phase))
    (found,) = parameters_of(CandidateFit(predictor_of(ripple), theta, 1.0, 1e4 * np.eye(len(theta))))
    assert found["phase"].value == pytest.approx(written, abs=1e-3)
    assert found["phase"].std > 0.0
    assert found["phase"].determined


def test_covariance_keeps_correlations_and_leaves_tolerated_numbers_out(fitted: CandidateFit) -> None:
    names, covariance = covariance_of(fitted)
    assert names == ("coulomb_friction@motor_1.level", "stiffness_error@body_2.rz.relative")
    assert covariance[0, 1] / np.sqrt(covariance[0, 0] * covariance[1, 1]) == pytest.approx(0.5)


def unit(effect: str, location: str, name: str, robot: str) -> str:
    return unit_of_parameter(Candidate(effects()[effect], location, ()), name, load_robot(robot))


@pytest.mark.parametrize(
    ("effect", "location", "name", "robot", "expected"),
    [
        ("coulomb_friction", "motor_1", "level", "four_mass_linear", "Nm"),
        ("coulomb_friction", "motor_1", "level", "emps", "N"),
        ("viscous_friction", "motor_1", "coefficient", "elbow", "Nm s/rad"),
        ("viscous_friction", "motor_1", "coefficient", "emps", "N s/m"),
        ("viscous_friction", "motor_1", "asymmetry", "emps", "1"),
        ("backlash", "motor_1", "gap", "elbow", "rad"),
        ("stiffness_error", "body_1.rz", "relative", "four_mass_linear", "1"),
        ("delay", "all", "time", "elbow", "s"),
    ],
)
def test_unit_of_a_number(effect: str, location: str, name: str, robot: str, expected: str) -> None:
    assert unit(effect, location, name, robot) == expected


@pytest.mark.parametrize("effect", effects().values(), ids=effects())
def test_every_fitted_number_states_its_unit(effect: type) -> None:
    for name in effect.ranges:
        assert re.search(r"\[[^\]]+\]", effect.model_fields[name].description or ""), name


def test_spread_of_estimates_is_as_stated() -> None:
    name = f"coulomb_friction@motor_1:level={LEVEL}"
    predictor = predictor_of(candidates_of(name)["coulomb_friction@motor_1"])
    off = []
    for seed in range(10, 16):
        data = data_of(name, seed=seed)
        starts = initial_values(predictor)
        best = starts[:, np.argmin(chi2_of(predictor, data, starts))]
        found = parameters_of(fit(predictor, data, best, 20, enough=FitSettings().exactly), data)[0]["level"]
        off.append((found.value - LEVEL) / found.std)
    assert 0.5 < np.sqrt(np.mean(np.square(off))) < 1.8


@pytest.mark.parametrize(("rise", "widest"), [(0.0, 0.02), (0.02, 0.1)])
def test_friction_that_rises_smoothly_is_within_its_interval(rise: float, widest: float) -> None:
    """Taken for a jump, its level comes out too small; without a rise the interval stays narrow."""
    names = ("coulomb_friction", "viscous_friction")
    found = diagnose(record_of_arm(imported=True, rise=rise), RobotWithEffects(arm(), ()), settings=settings_of(*names))
    sizes = {one.location: one.parameters["level"] for one in found.diagnosis.causes if one.effect == names[0]}
    for location, true in zip(("motor_1", "motor_2"), COULOMB, strict=True):
        assert abs(sizes[location].value - true) < 2 * sizes[location].std
        assert sizes[location].std < widest * true
