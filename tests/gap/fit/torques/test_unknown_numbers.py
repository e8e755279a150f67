"""Friction of a simulator in a robot file, which counts as none where torques do not show it; rotors; rough bodies."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import yaml

from flexros.effects import RobotWithEffects
from flexros.effects.friction.viscous_friction import ViscousFriction
from flexros.effects.kinds.base import PlacedEffect
from flexros.effects.left_out.body_difference import BodyDifference
from flexros.effects.left_out.tool_load import ToolLoad
from flexros.gap.candidates.tolerance import Tolerance, tolerance_of
from flexros.gap.diagnose import diagnose
from flexros.gap.fit.torques.missing_load import bodies_are_off, load_before_bodies
from flexros.gap.fit.torques.regression import regress_torque
from flexros.gap.fit.torques.rough_bodies import fitted_bodies, with_rough_bodies
from flexros.gap.fit.torques.solution import TorqueRegression
from flexros.gap.fit.torques.unknown_numbers import UnknownNumbers, unknown_numbers
from flexros.gap.measure_gap import measure_gap
from flexros.gap.settings import DiagnosisSettings, SearchSettings, TorqueStartSettings
from flexros.record.record import Record
from flexros.robot import Robot, load_robot, robot_from_data
from tests.gap.rigid_arm import ARM, COULOMB, INERTIA, VISCOUS, arm, motion, record_of_arm

FILE = 500.0
"""Viscous friction of the robot file; that of the log is `VISCOUS`."""
MOTORS = ("motor_1", "motor_2")


@cache
def damped() -> Robot:
    return arm().with_values({f"{name}.viscous_friction": FILE for name in MOTORS})


def damped_record() -> Record:
    """The log of an arm that has the friction of the file."""
    record, speed = record_of_arm(imported=True), motion()[1]
    held = 0.5 * (speed + np.vstack([speed[1:], speed[-1:]]))
    return replace(record, torque=record.torque + (FILE - VISCOUS) * held)


def unknown(record: Record) -> UnknownNumbers:
    return unknown_numbers(record, RobotWithEffects(damped(), ()), Tolerance())


def test_servos_without_rotors_get_none() -> None:
    """A file from a URDF has no rotors, and the torques of servos are not known."""
    servo = "{inertia: 0, servo: {stiffness: 20000, damping: 1000}}"
    stiff = robot_from_data(yaml.safe_load(ARM.replace("{inertia: 0}", servo)), "stiff.yaml").commanded_by("position")
    record = replace(record_of_arm(imported=True), command=motion()[0])
    assert unknown_numbers(record, RobotWithEffects(stiff, ()), Tolerance()) == UnknownNumbers()


def test_friction_that_torques_do_not_show_stands_for_none() -> None:
    found = unknown(record_of_arm(imported=True))
    assert found.placeholders == {"motor_1": FILE, "motor_2": FILE}
    np.testing.assert_allclose(list(found.inertias.values()), INERTIA, rtol=0.03)
    given = found.given_to(RobotWithEffects(damped(), ())).robot
    assert [given.parameters[f"{name}.viscous_friction"].value for name in MOTORS] == [0.0, 0.0]
    assert "at motor_1 (500), motor_2 (500) is that of a simulator" in found.warnings[0]
    assert not unknown_numbers(record_of_arm(imported=True), RobotWithEffects(arm(), ()), Tolerance()).warnings


def test_a_patched_model_lacks_no_friction() -> None:
    found = unknown(record_of_arm(imported=True))
    law = PlacedEffect(ViscousFriction(coefficient=-400.0), "motor_1")
    assert set(found.lacked_by(RobotWithEffects(damped(), ()).with_effects([law])).placeholders) == {"motor_2"}


def test_friction_that_torques_show_stays() -> None:
    found = unknown(damped_record())
    assert not found.placeholders
    given = found.given_to(RobotWithEffects(damped(), ())).robot
    assert given.parameters["motor_1.viscous_friction"].value == FILE


@pytest.mark.parametrize(("flange", "guessed"), [(2e-5, True), (2e-3, False)])
def test_a_rotor_that_torques_show_faintly_is_a_guess_beside_light_bodies(flange: float, *, guessed: bool) -> None:
    """A bare motor: without rotor, noise of its torque would throw the flange about."""
    motor = arm_of_one(flange)
    speed, acceleration = (0.05 * values[:, :1] for values in motion()[1:])
    noise = 0.05 * np.random.default_rng(3).standard_normal(speed.shape)
    log = record_of_arm(imported=True)
    record = replace(
        log, position=0.05 * log.position[:, :1], torque=0.1 * np.sign(speed) + 2e-3 * acceleration + noise
    )
    found = unknown_numbers(record, RobotWithEffects(motor, ()), Tolerance()).inertias
    assert list(found) == ["motor_1"] * guessed
    if guessed:
        assert 2e-4 < found["motor_1"] < 2e-2


def arm_of_one(inertia: float) -> Robot:
    """Return a motor that turns a flange about the vertical [kg m2], without rotor in its file."""
    file = yaml.safe_load(ARM)
    file["bodies"] = [
        {"mass": 0.05, "center_of_mass": [0, 0, 0], "inertia": dict.fromkeys(("xx", "yy", "zz"), inertia)}
        | {"directions": {"rz": {"spring": "rigid", "motor": {"inertia": 0}}}, "length": [0.02, 0, 0]}
    ]
    file["outputs"] = {"joints": {"coordinates": ["body_1.rz"]}}
    return robot_from_data(file, "flange.yaml")


ROUGH = {"body_1.mass": 8.0, "body_1.center_of_mass.x": 0.24, "body_2.mass": 2.5, "body_2.center_of_mass.x": 0.22}
"""Numbers of the bodies in a file that is a third off."""


@pytest.mark.slow
def test_bodies_that_are_far_off_are_allowed_for() -> None:
    """Held within the tolerance of the file, a load and another rotor stand for them."""
    record = record_of_arm(imported=True)
    file = RobotWithEffects(arm().with_values(ROUGH), ())
    exact = tolerance_of(file.robot, {})
    exact = replace(exact, deviations=(0.01,) * len(exact.names))
    found = unknown_numbers(record, file, exact)
    assert found.rough == TorqueStartSettings().rough_bodies
    assert found.load is None
    np.testing.assert_allclose(list(found.inertias.values()), INERTIA, rtol=0.1)
    assert "are off by more than their tolerance: 15 %" in found.warnings[0]
    tolerated = found.tolerated(exact, file.robot)
    deviations = dict(zip(tolerated.names, tolerated.deviations, strict=True))
    assert deviations["body_2.mass"] == found.rough
    assert deviations["body_2.length.x"] == 0.01
    assert not unknown_numbers(record, file, exact, as_stated=True).rough
    assert "body_2.mass" in found.names(file.robot)
    assert not unknown_numbers(record, RobotWithEffects(arm(), ()), exact).rough


@pytest.mark.slow
def test_inertias_that_are_far_off_do_not_make_masses_rough() -> None:
    """A file may state them about the joint; then they are candidates, and the rotors are right."""
    file = RobotWithEffects(arm().with_values({"body_2.inertia.yy": 0.24, "body_2.inertia.zz": 0.24}), ())
    found = unknown_numbers(record_of_arm(imported=True), file, tolerance_of(file.robot, {}))
    assert not found.rough
    assert found.load is None
    np.testing.assert_allclose(list(found.inertias.values()), INERTIA, rtol=0.1)


@pytest.mark.parametrize("driven", [False, True])
def test_a_motor_that_is_not_driven_does_not_make_bodies_rough(*, driven: bool) -> None:
    """Bodies without weight would explain that it has no torque."""
    record = record_of_arm(imported=True)
    found = regress_torque(record, RobotWithEffects(arm(), ()), tolerance_of(arm(), {}))
    assert found is not None
    within = replace(found, left=np.array([0.5, 1.0]), rest=np.array([1.0, 3.0]))
    wide = replace(within, left=np.array([0.4, 1e-5]))
    record = replace(record, torque=record.torque * [1.0, driven])
    assert bodies_are_off(wide, within, lambda *_, **__: within, record, TorqueStartSettings()) is driven


def test_a_heavier_last_body_does_not_make_all_bodies_rough() -> None:
    """That is a payload error."""
    heavy = record_of_arm(imported=True, load=1.0)
    assert not unknown_numbers(heavy, RobotWithEffects(arm(), ()), tolerance_of(arm(), {})).rough


@pytest.mark.slow
def test_the_patch_states_the_friction_of_the_log_against_that_of_the_file() -> None:
    search = SearchSettings(effects=("coulomb_friction", "viscous_friction", "torque_bias", "motor_inertia_error"))
    settings = DiagnosisSettings(where=None, next_experiment=None, search=search)
    log, held = (record_of_arm(imported=True, seed=seed, seconds=10.0) for seed in (5, 6))
    result = diagnose(log, damped(), holdout=held, settings=settings)
    friction = {one.location: one.effect for one in result.patch if isinstance(one.effect, ViscousFriction)}
    sizes = [getattr(friction[name], "coefficient", np.nan) for name in MOTORS]
    np.testing.assert_allclose(sizes, VISCOUS - FILE, atol=0.3)
    levels = [one.effect.level for one in result.patch if one.effect.name == "coulomb_friction"]  # type: ignore[attr-defined]
    np.testing.assert_allclose(levels, COULOMB, rtol=0.05)
    assert len(result.patch) == 6
    assert any("is that of a simulator" in text for text in result.diagnosis.warnings)
    repaired = RobotWithEffects(damped(), ()).with_effects(result.patch)
    gap = measure_gap(held, RobotWithEffects(damped(), ()), repaired=repaired, settings=settings).numbers
    assert gap.closed_fraction is not None
    assert gap.closed_fraction > 0.95


def test_numbers_that_an_exact_file_lacks_are_uncertain_all_the_same() -> None:
    """They are estimates, of which a fit of the log must find the rest."""
    unknown = UnknownNumbers({"motor_1": 0.8}, ToolLoad(mass=1.0, x=0.1, z=0.2), 3.0)
    robot = unknown.given_to(RobotWithEffects(arm(), ())).robot
    found = unknown.tolerated(Tolerance(), robot)
    center = ("body_2.center_of_mass.x", "body_2.center_of_mass.z")  # along y there is nothing
    assert set(found.names) == {"motor_1.inertia", "body_2.mass", *center}
    assert min(found.deviations) > 0


def test_a_patch_holds_bodies_that_are_far_off() -> None:
    """Without them it would be one of another model than that whose gap was closed."""
    robot = arm()
    factors = {"body_2.mass": 1.2, "body_2.center_of_mass.x": 0.9, "body_2.inertia.zz": 1.1, "body_1.length.x": 2.0}
    (placed,) = fitted_bodies(robot, factors)
    assert placed.location == "body_2"
    changed = RobotWithEffects(robot, ()).with_effects([placed]).robot
    for name in ("body_2.mass", "body_2.center_of_mass.x", "body_2.inertia.zz"):
        assert changed.parameters[name].value == pytest.approx(factors[name] * robot.parameters[name].value)


def test_an_inertia_that_no_body_can_have_grows_with_the_mass() -> None:
    robot = load_robot("six_axis")
    (placed,) = fitted_bodies(robot, {"body_2.mass": 1.2, "body_2.inertia.zz": 30.0})
    changed = RobotWithEffects(robot, ()).with_effects([placed]).robot
    for entry in ("xx", "yy", "zz"):
        name = f"body_2.inertia.{entry}"
        assert changed.parameters[name].value == pytest.approx(1.2 * robot.parameters[name].value)


@pytest.mark.parametrize(("factor", "kind"), [(1.0, ToolLoad), (0.8, BodyDifference)])
def test_where_a_fit_leaves_nothing_of_a_load_its_body_is_lighter(factor: float, kind: type[object]) -> None:
    """A load has no negative mass: writing a patch of such a fit ended in an internal error."""
    numbers, bare = UnknownNumbers(load=ToolLoad(mass=0.5, x=0.3), bare=3.0), RobotWithEffects(arm(), ())
    loaded = numbers.given_to(bare).robot
    tolerance = SimpleNamespace(names=("body_2.mass",), logarithms=lambda _: np.log([factor]))
    fit: Any = SimpleNamespace(predictor=SimpleNamespace(robot=loaded, tolerance=tolerance), deviations=np.zeros(1))
    (found,) = numbers.fitted(fit)
    assert isinstance(found.effect, kind)
    repaired, fitted = bare.with_effects([found]).robot, loaded.with_values({"body_2.mass": factor * 3.5})
    for name, parameter in fitted.parameters.items():
        assert repaired.parameters[name].value == pytest.approx(parameter.value, abs=1e-12)


@pytest.mark.parametrize(
    ("tolerated", "rough", "mass", "found"),
    [(1.3, 1.02, 1.0, True), (1.1, 1.02, 1.0, False), (1.3, 0.9, 1.0, False), (1.3, 1.02, 0.1, False)],
)
def test_a_load_that_explains_more_than_errors_of_all_bodies_is_missing(
    tolerated: float, rough: float, mass: float, found: bool
) -> None:
    """In slow motion friction and rotors stand for its weight, so that it lowers by little what they leave."""
    settings, file = TorqueStartSettings(), arm()
    within = tolerance_of(file, {})
    plain = regress_torque(record_of_arm(imported=True), RobotWithEffects(file, ()), Tolerance())
    assert plain is not None
    left = {Tolerance(): 1.4, within: tolerated, with_rough_bodies(within, settings.rough_bodies): rough}

    def regress(tolerance: Tolerance, *, load: str = "none") -> TorqueRegression:
        if load == "point":
            return replace(plain, left=np.ones(2), load=mass * np.array([1.0, 0.1, 0.0, 0.2]))
        return replace(plain, left=np.full(2, left[tolerance]))

    one = load_before_bodies(regress, file, within, file.n_motors, settings)
    assert (one is not None) == found
    if one is not None:
        assert (one[1].mass, one[1].x, one[1].z) == pytest.approx((1.0, 0.1, 0.2))
