"""Curves as candidates: springs of unknown law in logs that count as measured, and what a log must cover."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from typing import ClassVar

import casadi as ca
import numpy as np
import pytest

from flexros.effects import PlacedLaw, RobotWithEffects, parse_effect, place_effects
from flexros.effects.gear.spring_curve import SpringCurve
from flexros.effects.kinds.base import Stage
from flexros.effects.kinds.gear_law import AbstractGearLaw, GearState, GearTorques
from flexros.gap.candidates.candidate import Candidate
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.diagnose import diagnose
from flexros.gap.fit.directions import Directions
from flexros.gap.fit.initial_values import starts_of
from flexros.gap.fit.null_fit import fit_null
from flexros.gap.residuals.prepare_fit_data import fit_data
from flexros.gap.result import DiagnosisResult
from flexros.gap.search.curve_candidates import list_curves, without_shared
from flexros.gap.search.prepare import prepare_search
from flexros.gap.settings import DiagnosisSettings, SearchSettings
from flexros.record.record import Record
from flexros.robot import Robot, load_robot
from flexros.robot.symbolic.kinematics import Value
from flexros.simulate.plant import Plant
from tests.effects.effect_runs import GearLaw

pytestmark = pytest.mark.slow

ROBOT = load_robot("two_mass")
T, STIFFNESS, NOISE = ROBOT.sample_time, 6e4, 1e-5
RIVALS = (
    *("coulomb_friction", "viscous_friction", "friction_curve", "torque_bias", "torque_curve", "torque_drift"),
    "friction_over_position",
    *("stiffness_error", "damping_error", "nonlinear_stiffness", "backlash", "hysteresis", "spring_curve"),
    *("motor_inertia_error", "torque_gain_error"),
)
"""Friction, springs and curves, which may stand for each other."""
SETTINGS = DiagnosisSettings(where=None, next_experiment=None, search=SearchSettings(effects=RIVALS))
FRICTION = {"coulomb_friction@motor_1": 6.0, "viscous_friction@motor_1": 10.0}
UNEVEN = {"uneven_50", "uneven_100", "asymmetry"}
TEXTS = ("coulomb_friction@motor_1:level=6", "viscous_friction@motor_1:coefficient=10")


class OneSided(AbstractGearLaw):
    """A spring that becomes twice as stiff, to one side: no effect of the library."""

    name: ClassVar[str] = "one_sided"
    stage: ClassVar[Stage] = "gear"
    size: ClassVar[str] = "relative"
    rank: ClassVar[int] = 1

    relative: float = 1.0

    def added(self, gear: GearState, values: Mapping[str, Value]) -> GearTorques:
        return gear.transmits(values["relative"] * STIFFNESS * ca.fmax(gear.deflection - 3e-4, 0))


def measured(*texts: str, one_sided: bool = False, swing: float = 0.4, samples: int) -> Record:
    """Simulate a drive that is shaken at 1.3 to 29 Hz while it swings, as a log of a real machine.

    Args:
        texts: Effects.
        one_sided: Whether the spring is one-sided.
        swing: Frequency of the swing [Hz].
        samples: Length.
    """
    placed = place_effects(ROBOT, [parse_effect(text, "test") for text in texts])
    hidden = (PlacedLaw("one_sided@body_1.rz", OneSided(), "body_1.rz"),) if one_sided else ()
    plant = Plant(placed.robot, T, np.zeros(4), substeps=4, laws=(*placed.laws, *hidden))
    rng, time = np.random.default_rng(1), T * np.arange(samples)
    lines = np.arange(1.3, 30, 1.7)
    shaking = 30 * np.sin(2 * np.pi * lines * time[:, None] + rng.uniform(0, 6, len(lines))).sum(axis=1)
    position, torque = np.zeros((samples, 1)), np.zeros((samples, 1))
    for k in range(samples):
        _, motor, _, speed = plant.state
        position[k] = motor
        torque[k] = shaking[k] + 200 * (0.5 * np.sin(2 * np.pi * swing * time[k]) - motor) - 20 * speed
        plant.advance(torque[k])
    noise = NOISE * rng.standard_normal(position.shape)
    return Record("log", T, position + noise, torque, np.ones(samples, dtype=bool), imported=True)


@cache
def diagnosed(*texts: str, one_sided: bool = False) -> DiagnosisResult:
    record = measured(*texts, one_sided=one_sided, samples=12000 if one_sided else 8000)
    stated = {"torque": 0.05} if one_sided else {}  # no smaller tolerance is tried beside the curve
    return diagnose(record, RobotWithEffects(ROBOT, ()), tolerance=stated, settings=SETTINGS)


def causes(found: DiagnosisResult) -> dict[str, dict[str, tuple[float, float]]]:
    """Return value and standard deviation of all parameters of all causes."""
    return {
        f"{one.effect}@{one.location}": {name: (size.value, size.std) for name, size in one.parameters.items()}
        for one in found.diagnosis.causes
    }


def test_spring_of_no_law_is_named_at_its_place() -> None:
    found = diagnosed(*TEXTS, one_sided=True)
    assert causes(found).keys() == {*FRICTION, "spring_curve@body_1.rz"}
    assert found.diagnosis.verdict == "partly_explained"
    assert (found.diagnosis.gap.closed_fraction or 0.0) > 0.99
    (share,) = [one for one in found.diagnosis.budget if one.effect == "spring_curve"]
    assert (share.joint, share.cause_class) == ("motor_1", "gear")


def test_spring_of_no_law_is_recovered_within_the_deflections_of_the_log() -> None:
    found = diagnosed(*TEXTS, one_sided=True)
    (curve,) = [one.effect for one in found.patch if isinstance(one.effect, SpringCurve)]
    assert curve.low < -4e-3
    assert curve.high > 2e-3
    law = GearLaw(curve, STIFFNESS)
    deflections = np.linspace(curve.low, curve.high, 21)
    torque = np.array([law.torques(float(d), law.start(float(d)))[0] for d in deflections])
    true = STIFFNESS * (deflections + np.maximum(deflections - 3e-4, 0))
    np.testing.assert_allclose(torque, true, atol=0.03 * np.ptp(true))


def test_sizes_of_friction_beside_the_curve_are_right_and_all_sizes_determined() -> None:
    found = causes(diagnosed(*TEXTS, one_sided=True))
    for name, true in FRICTION.items():
        size, std = next(iter(found[name].values()))
        assert abs(size - true) < max(3 * std, 0.01 * true)
    assert all(std < 5 for _, std in found["spring_curve@body_1.rz"].values())  # of up to 280 Nm


@pytest.mark.parametrize("law", ["nonlinear_stiffness@body_1.rz:relative=0.5,knee=5e-4", "backlash@motor_1:gap=3e-4"])
def test_spring_of_a_known_law_needs_no_curve(law: str) -> None:
    found = causes(diagnosed(*TEXTS, law))
    assert law.partition(":")[0] in found
    assert "spring_curve@body_1.rz" not in found


def test_friction_alone_needs_no_curve() -> None:
    assert causes(diagnosed(*TEXTS)).keys() == FRICTION.keys()


def curves_of(record: Record, *fitted: str, robot: Robot = ROBOT) -> dict[str, Candidate]:
    """List the curves that compete in a log, beside the fit with candidates of these names."""
    model = RobotWithEffects(robot, ())
    null = fit_null(fit_data(record, model, SETTINGS), model, Tolerance())
    search = prepare_search(null, SETTINGS)
    fit = search.null.fit
    if fitted:
        hypothesis = tuple(one for one in search.candidates() if one.name in fitted)
        theta = np.concatenate([one.starts()[0] for one in hypothesis])
        fit = replace(fit, predictor=null.predictor(hypothesis), theta=theta)
    return {one.name: one for one in list_curves(search, fit)}


@cache
def short() -> Record:
    return measured(*TEXTS, samples=3000, swing=2.0)


def free_of(candidate: Candidate) -> set[str]:
    return {one.name for one in candidate.free}


def test_knots_of_a_spring_are_within_the_deflections_of_the_log() -> None:
    knots = dict(curves_of(short())["spring_curve@body_1.rz"].fixed)
    assert -0.02 < knots["low"] < -1e-3
    assert 1e-3 < knots["high"] < 0.02


def test_largest_torque_of_a_spring_curve_is_that_of_the_nominal_spring() -> None:
    curve = curves_of(short())["spring_curve@body_1.rz"]
    deflection = max(abs(float(value)) for _, value in curve.fixed)
    assert curve.free[0].high == pytest.approx(STIFFNESS * deflection, rel=0.2)


def test_one_size_of_a_spring_curve_is_that_of_an_error_of_its_stiffness() -> None:
    alone = free_of(curves_of(short())["spring_curve@body_1.rz"])
    beside = free_of(curves_of(short(), "stiffness_error@body_1.rz")["spring_curve@body_1.rz"])
    assert alone - beside == {"positive_100"}


def test_curve_over_time_covers_the_times_of_the_log() -> None:
    begin, end = (value for _, value in curves_of(short())["torque_drift@motor_1"].fixed)
    assert (begin, end) == pytest.approx((0.0, 3000 * T), abs=0.5)


def test_curve_over_time_competes_only_where_the_motion_repeats() -> None:
    assert "torque_drift@motor_1" in curves_of(short())
    names = curves_of(measured(*TEXTS, samples=3000, swing=0.2)).keys()
    assert "torque_drift@motor_1" not in names
    assert "torque_curve@motor_1" in names


def directions(candidate: Candidate) -> Directions:
    starts = starts_of((candidate,))
    n = starts.shape[1]
    changes = np.arange(5.0 * n).reshape(5, n).astype(np.float32)
    return Directions(candidate, starts, changes, np.ones(n, dtype=bool))


def test_of_two_curves_at_a_motor_one_has_the_size_of_a_bias() -> None:
    curves = curves_of(short())
    over_time, over_position = (directions(curves[f"{name}@motor_1"]) for name in ("torque_drift", "torque_curve"))
    beside = without_shared(over_time, [over_position])
    assert free_of(over_time.candidate) - free_of(beside.candidate) == {"torque_1"}
    np.testing.assert_array_equal(beside.changes, over_time.changes[:, 1:])
    np.testing.assert_array_equal(starts_of((beside.candidate,)), beside.starts)
    assert without_shared(over_time, [directions(curves["friction_curve@motor_1"])]) is over_time


@pytest.mark.parametrize("both", [False, True])
def test_friction_in_one_direction_has_no_difference_between_directions(both: bool) -> None:
    """Mean and difference are one torque there: a curve had been all difference, and drove a motor that turned back."""
    record = measured(*TEXTS, samples=1500)
    turning = record.position + (0 if both else 100 * T * np.arange(record.n_samples)[:, None])
    model = RobotWithEffects(ROBOT, ())
    search = prepare_search(fit_null(fit_data(record, model, SETTINGS), model, Tolerance()), SETTINGS)
    data = replace(search.data, record=replace(record, position=turning))
    search = replace(search, null=replace(search.null, data=data))
    curves = {one.effect.name: one for one in list_curves(search, search.null.fit) if one.location == "motor_1"}
    curve = curves["friction_curve"]
    assert ("friction_over_position" in curves) is both  # else it is the torque over position
    assert "torque_curve" in curves
    (viscous,) = (one for one in search.candidates() if one.effect.name == "viscous_friction")
    names = {free.name for free in (*curve.free, *viscous.free)}
    assert {"standstill", "speed_100", "coefficient"} <= names
    assert names & UNEVEN == (UNEVEN if both else set())
