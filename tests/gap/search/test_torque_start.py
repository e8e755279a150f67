"""The search of a real machine begins with friction and inertia that its torques show."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
import yaml

from flexros.arrays import FloatArray
from flexros.effects import PlacedEffect, RobotWithEffects
from flexros.effects.counterbalance import Counterbalance
from flexros.effects.friction.coulomb_friction import CoulombFriction
from flexros.effects.torque_curve import TorqueCurve
from flexros.gap.candidates.tolerance import Tolerance, tolerance_of
from flexros.gap.diagnose import diagnose
from flexros.gap.fit.candidate_fit import CandidateFit
from flexros.gap.fit.null_fit import NullFit, fit_null
from flexros.gap.fit.torques.unknown_numbers import unknown_numbers
from flexros.gap.prediction.predictor import Predictor
from flexros.gap.residuals.fit_data import FitData
from flexros.gap.residuals.prepare_fit_data import fit_data
from flexros.gap.result import DiagnosisResult
from flexros.gap.search.torque_start import TorqueStart, base_fit, first_values, torque_start, with_torques
from flexros.gap.settings import DiagnosisSettings, NoiseSettings, SearchSettings
from flexros.record.record import Record
from flexros.record.torques.torque_noise import without_torque_noise
from flexros.robot import Robot, load_robot, robot_from_data
from tests.gap.rigid_arm import ARM, COULOMB, INERTIA, VISCOUS, arm, motion, record_of_arm

FRICTION = {f"{effect}@motor_{motor}" for effect in ("coulomb_friction", "viscous_friction") for motor in (1, 2)}
RIVALS = (
    *("coulomb_friction", "viscous_friction", "stribeck_friction"),
    *("torque_bias", "torque_gain_error", "motor_inertia_error"),
)
"""What is most like friction; in the first diagnosis all effects compete."""


def settings_of(*effects: str) -> DiagnosisSettings:
    """Let some effects compete, with a tolerance of the torques that is stated, so that no smaller one is tried."""
    noise, search = NoiseSettings(signal_tolerance=0.05), SearchSettings(effects=effects)
    return DiagnosisSettings(where=None, next_experiment=None, sensitivity=None, noise=noise, search=search)


FEW = settings_of(*RIVALS)


def log_of_arm(**others: Any) -> Record:
    """Ten seconds of the arm, as of a real machine."""
    return record_of_arm(imported=True, seconds=10.0, **others)


@cache
def prepared() -> tuple[FitData, RobotWithEffects, Tolerance]:
    record, model = log_of_arm(), RobotWithEffects(arm(), ())
    unknown = unknown_numbers(record, model, tolerance_of(model.robot, {}))
    model = unknown.given_to(model)
    tolerance = unknown.tolerated(tolerance_of(model.robot, {}), model.robot)
    return fit_data(record, model, DiagnosisSettings()), model, tolerance


@cache
def start() -> TorqueStart:
    found = torque_start(*prepared(), DiagnosisSettings())
    assert found is not None
    return found


@cache
def null() -> NullFit:
    data, model, tolerance = prepared()
    return fit_null(data, model, tolerance)


def first(**search: tuple[str, ...]) -> CandidateFit | None:
    return first_values(start(), null(), DiagnosisSettings(search=SearchSettings(**search)))


@cache
def result() -> DiagnosisResult:
    settings = DiagnosisSettings(where=None, next_experiment=None)
    held = log_of_arm(seed=6)
    return diagnose(log_of_arm(), arm(), holdout=held, settings=settings)


def test_first_values_are_those_of_the_torques() -> None:
    found = first()
    assert found is not None
    assert found.names >= FRICTION
    values = dict(zip((one.name for one in found.hypothesis), found.predictor.values(found.theta)))
    assert values["coulomb_friction@motor_1"]["level"] == pytest.approx(COULOMB[0], rel=0.05)
    assert values["viscous_friction@motor_2"]["coefficient"] == pytest.approx(VISCOUS[1], rel=0.05)


def test_only_named_effects_and_motors_are_in_it() -> None:
    found = first(effects=("coulomb_friction",), joints=("motor_2",))
    assert found is not None
    assert found.names == {"coulomb_friction@motor_2"}


def test_without_a_competing_effect_there_is_no_start() -> None:
    assert first(effects=("backlash", "payload_error")) is None


def test_bodies_with_which_no_robot_can_be_predicted_are_less_off(monkeypatch: pytest.MonkeyPatch) -> None:
    found, few = start(), null()
    deviations = np.full(len(found.regression.deviations), 4.0)
    far = replace(found, regression=replace(found.regression, deviations=deviations))

    def diverging(predictor: Predictor, data: FitData, thetas: FloatArray) -> FloatArray:
        return np.where(np.abs(thetas[predictor.n_effect :]).max(axis=0) > 3, np.inf, 1.0)

    monkeypatch.setattr("flexros.gap.search.torque_start.chi2_of", diverging)
    first = first_values(far, few, DiagnosisSettings())
    assert first is not None
    assert np.isfinite(first.chi2)
    np.testing.assert_allclose(first.deviations, few.predictor(()).tolerance.along(0.25 * deviations))


def test_a_start_that_removes_little_is_none() -> None:
    found = first()
    assert found is not None
    fitted = base_fit(null(), found, DiagnosisSettings())
    assert fitted is not None
    better = replace(null(), fit=replace(null().fit, chi2=1.01 * fitted.chi2))
    assert base_fit(better, found, DiagnosisSettings()) is None


def test_our_own_simulations_need_none() -> None:
    data, model, tolerance = prepared()
    simulated = replace(data, record=replace(data.record, imported=False), nominal_level=1.0)
    assert torque_start(simulated, model, tolerance, DiagnosisSettings()) is None


def test_a_simulated_log_far_from_its_model_begins_with_its_torques_too() -> None:
    data, model, tolerance = prepared()
    simulated = replace(data, record=replace(data.record, imported=False), nominal_level=1e6)
    found = torque_start(simulated, model, tolerance, DiagnosisSettings())
    assert found is not None
    assert {f"{one.effect.name}@{one.location}" for one, _ in found.hypothesis()} >= FRICTION


@pytest.mark.slow
def test_friction_of_all_motors_is_named_and_rotors_are_numbers_of_the_model() -> None:
    diagnosis = result().diagnosis
    assert {f"{cause.effect}@{cause.location}" for cause in diagnosis.causes} == FRICTION
    assert diagnosis.gap.closed_fraction is not None
    assert diagnosis.gap.closed_fraction > 0.95
    numbers = {number.name: number.value for number in diagnosis.model_numbers}
    np.testing.assert_allclose([numbers["motor_1.inertia"], numbers["motor_2.inertia"]], INERTIA, rtol=0.05)
    assert all(cause.closed_fraction is not None for cause in diagnosis.causes)


@pytest.mark.slow
def test_the_patch_holds_rotors_and_friction() -> None:
    patched = {f"{placed.effect.name}@{placed.location}" for placed in result().patch}
    assert patched == FRICTION | {"rotor_inertia@motor_1", "rotor_inertia@motor_2"}


def test_a_base_that_gains_no_more_than_chance_is_none() -> None:
    """Then every candidate must be tried alone: a base that explains nothing would end the search."""
    found = first()
    assert found is not None
    assert base_fit(null(), found, DiagnosisSettings()) is not None
    strict = DiagnosisSettings().ranking.model_copy(update={"detected": 1e9})
    assert base_fit(null(), found, DiagnosisSettings(ranking=strict)) is None


@pytest.mark.slow
def test_clear_asymmetry_of_friction_is_found() -> None:
    uneven = [log_of_arm(seed=seed, asymmetry=0.4) for seed in (5, 6)]
    found = diagnose(uneven[0], arm(), holdout=uneven[1], settings=FEW).diagnosis
    assert {f"{cause.effect}@{cause.location}" for cause in found.causes} == FRICTION
    parameters = {f"{cause.effect}@{cause.location}": cause.parameters for cause in found.causes}
    assert parameters["viscous_friction@motor_1"]["asymmetry"].value == pytest.approx(0.4, rel=0.1)
    assert "asymmetry" not in parameters["viscous_friction@motor_2"]


def complete_arm() -> Robot:
    """Load the arm with its rotors and viscous friction in the file."""
    data = yaml.safe_load(ARM)
    for body, inertia, viscous in zip(data["bodies"], INERTIA, VISCOUS, strict=True):
        body["directions"]["ry"]["motor"] = {"inertia": float(inertia), "viscous_friction": float(viscous)}
    return robot_from_data(data, "arm.yaml")


@pytest.mark.slow
def test_friction_whose_mean_is_nominal_returns_for_its_asymmetry() -> None:
    """The torques show no viscous friction beyond the nominal one, so it is left out at first."""
    uneven = [log_of_arm(seed=seed, asymmetry=1.0) for seed in (5, 6)]
    found = diagnose(uneven[0], complete_arm(), holdout=uneven[1], settings=FEW).diagnosis
    parameters = {f"{cause.effect}@{cause.location}": cause.parameters for cause in found.causes}
    assert parameters.keys() == FRICTION - {"viscous_friction@motor_2"}
    assert parameters["viscous_friction@motor_1"]["asymmetry"].value == pytest.approx(1.0, rel=0.1)


@pytest.mark.slow
def test_friction_of_the_nominal_model_that_is_too_large_is_reduced() -> None:
    """Rotors are estimated beside it, and what the model has too much of is a negative level."""
    record = log_of_arm()
    level = CoulombFriction(level=1.5 * COULOMB[0])
    model = RobotWithEffects(arm(), ()).with_effects([PlacedEffect(level, "motor_1")])
    unknown = unknown_numbers(record, model, tolerance_of(model.robot, {}))
    assert list(unknown.inertias.values()) == pytest.approx(INERTIA, rel=0.1)
    found = diagnose(record, model, holdout=log_of_arm(seed=6), settings=FEW).diagnosis
    levels = {one.location: one.parameters["level"].value for one in found.causes if one.effect == "coulomb_friction"}
    assert levels["motor_1"] == pytest.approx(-0.5 * COULOMB[0], rel=0.05)
    assert levels["motor_2"] == pytest.approx(COULOMB[1], rel=0.05)


@pytest.mark.slow
def test_friction_of_the_file_of_which_the_torques_show_nothing_is_a_finding() -> None:
    """The measured torques lack a little more than the viscous friction: the size is at the end of its range."""
    speed = motion(10.0)[1]
    logs = [replace(log, torque=log.torque - 1.1 * VISCOUS * speed) for log in (log_of_arm(), log_of_arm(seed=6))]
    found = diagnose(logs[0], complete_arm(), holdout=logs[1], settings=FEW)
    causes = {f"{one.effect}@{one.location}": one.parameters for one in found.diagnosis.causes}
    size = causes["viscous_friction@motor_1"]["coefficient"]
    assert size.value == -VISCOUS[0]
    assert not size.at_limit
    assert {f"{one.effect.name}@{one.location}" for one in found.patch} >= {"viscous_friction@motor_1"}


@pytest.mark.slow
def test_a_load_of_many_times_the_last_body_is_found() -> None:
    """Its search ends at nine times the mass and is widened."""
    loaded = [log_of_arm(seed=seed, load=11.0) for seed in (5, 6)]
    settings = settings_of("coulomb_friction", "payload_error")
    found = diagnose(loaded[0], complete_arm(), holdout=loaded[1], settings=settings).diagnosis
    causes = {f"{cause.effect}@{cause.location}": cause.parameters for cause in found.causes}
    assert causes["payload_error@tool"]["relative"].value == pytest.approx(11.0, rel=0.15)
    assert not causes["payload_error@tool"]["relative"].at_limit


def start_with(balance: tuple[float, float]) -> TorqueStart:
    record, model = log_of_arm(balance=balance), RobotWithEffects(arm(), ())
    data = fit_data(record, model, DiagnosisSettings())
    found = torque_start(data, model, Tolerance(), DiagnosisSettings())
    assert found is not None
    return found


def test_search_begins_with_a_counterbalance_that_torques_show() -> None:
    sizes = {one.name: values for one, values in start_with((40.0, -15.0)).hypothesis()}
    assert set(sizes) == {*FRICTION, "counterbalance@motor_1"}
    np.testing.assert_allclose(sizes["counterbalance@motor_1"], (40.0, -15.0), rtol=0.03)
    np.testing.assert_allclose([sizes[f"coulomb_friction@motor_{k}"][0] for k in (1, 2)], COULOMB, rtol=0.03)


def test_small_torque_over_the_position_is_no_counterbalance() -> None:
    assert {one.name for one, _ in start_with((0.2, 0.0)).hypothesis()} <= FRICTION | {"torque_bias@motor_1"}


@pytest.mark.slow
def test_counterbalance_is_named_with_its_size() -> None:
    log, held = (log_of_arm(seed=seed, balance=(40.0, -15.0)) for seed in (5, 6))
    known = arm().with_values({"motor_1.inertia": INERTIA[0], "motor_2.inertia": INERTIA[1]})
    found = diagnose(log, known, holdout=held, settings=settings_of(*RIVALS, "payload_error", "counterbalance"))
    causes = {f"{one.effect}@{one.location}": one for one in found.diagnosis.causes}
    assert found.diagnosis.verdict == "explained"
    assert set(causes) == {*FRICTION, "counterbalance@motor_1"}
    sizes = causes["counterbalance@motor_1"].parameters
    for name, size in (("cosine", 40.0), ("sine", -15.0)):
        assert sizes[name].std is not None
        assert abs(sizes[name].value - size) < 3 * sizes[name].std < 0.3 * abs(size)


def test_an_offset_of_the_torques_begins_the_search() -> None:
    """Without it, friction and bodies would stand for it."""
    found = torque_start_of(log_of_arm(offset=3.0))
    assert found.regression.bias[0] == pytest.approx(-3.0, rel=0.05)
    assert found.regression.bias[1] == 0.0
    assert "torque_bias@motor_1" in {candidate.name for candidate, _ in found.hypothesis()}


def test_viscous_friction_that_differs_by_direction_is_no_offset() -> None:
    found = torque_start_of(log_of_arm(asymmetry=0.8))
    assert not found.regression.bias.any()


def torque_start_of(record: Record) -> TorqueStart:
    model = RobotWithEffects(arm(), ())
    model = unknown_numbers(record, model, tolerance_of(model.robot, {})).given_to(model)
    found = torque_start(
        fit_data(record, model, DiagnosisSettings()), model, tolerance_of(model.robot, {}), DiagnosisSettings()
    )
    assert found is not None
    return found


def test_torques_count_beside_predictions_on_a_rigid_machine_alone() -> None:
    data = prepared()[0]
    assert with_torques(data, start()).torques is not None
    assert with_torques(data, None).torques is None
    simulated = replace(data, record=replace(data.record, imported=False))
    assert with_torques(simulated, start()).torques is None
    commanded = replace(data, record=replace(data.record, command=data.record.position))
    assert with_torques(commanded, start()).torques is None
    behind_springs = replace(start(), model=RobotWithEffects(load_robot("elbow"), ()))
    assert with_torques(data, behind_springs).torques is None


@pytest.mark.slow
def test_a_counterbalance_that_carries_little_takes_the_place_of_its_curve() -> None:
    """It is too small beside the weight for the torques alone to tell, and is a curve over position at first."""
    found = diagnose(
        log_of_arm(balance=(2.0, 8.0)), arm(), settings=settings_of(*RIVALS, "torque_curve", "counterbalance")
    )
    (spring,) = [one.effect for one in found.patch if isinstance(one.effect, Counterbalance)]
    assert spring.sine == pytest.approx(8.0, rel=0.02)
    assert spring.cosine == pytest.approx(2.0, abs=0.3)
    assert not any(isinstance(one.effect, TorqueCurve) for one in found.patch)


@pytest.mark.slow
def test_white_noise_of_measured_torques_is_no_lag() -> None:
    """A lag takes some of it away, so that one is found as long as the noise counts as torque."""
    record = record_of_arm(imported=True)
    noise = np.array([3.0, 1.5]) * np.random.default_rng(3).standard_normal(record.torque.shape)
    measured = replace(record, torque=record.torque + noise, noted=record.torque + noise)
    settings = settings_of(*RIVALS, "actuator_lag", "delay")
    found = diagnose(without_torque_noise(measured, arm()), arm(), settings=settings)
    assert {f"{one.effect}@{one.location}" for one in found.diagnosis.causes if one.probability > 0.5} == FRICTION
