"""A measured drive with a spring: effects that hide behind others, and others that stand for them."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
import pytest

from flexros.effects import RobotWithEffects, parse_effect, place_effects
from flexros.gap.candidates.tolerance import tolerance_of
from flexros.gap.diagnose import diagnose
from flexros.gap.fit.limits import at_limits
from flexros.gap.fit.null_fit import fit_null
from flexros.gap.residuals.prepare_fit_data import fit_data
from flexros.gap.search import richer_laws
from flexros.gap.search.common_scale import with_common_scale
from flexros.gap.search.curves import with_curves
from flexros.gap.search.prepare import prepare_search
from flexros.gap.search.regrouping import with_gains
from flexros.gap.search.richer_laws import with_simpler_effects
from flexros.gap.settings import DiagnosisSettings, SearchSettings
from flexros.random_streams import generator
from flexros.record.record import Record
from flexros.robot import load_robot
from flexros.simulate.plant import Plant

if TYPE_CHECKING:
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.search.fits.candidate_fits import Search

pytestmark = pytest.mark.slow

FRICTION = ("coulomb_friction@motor_1:level=6", "viscous_friction@motor_1:coefficient=10")
N, FEW = 12_000, 7_000
"""Samples of a log in which a small effect has to show, and of the others."""
RIVALS = (
    *("coulomb_friction", "viscous_friction", "stribeck_friction", "presliding_friction", "hysteresis"),
    *("backlash", "stiffness_error"),
    *("nonlinear_stiffness", "damping_error", "motor_inertia_error", "torque_gain_error", "payload_error"),
)
"""Friction, springs, and numbers of the drive."""
SETTINGS = DiagnosisSettings(where=None, next_experiment=None, search=SearchSettings(effects=RIVALS))


@cache
def record_of(*effects: str, samples: int = N) -> Record:
    """Drive a motor by sines and a slow position loop, and record it as another program would."""
    robot = load_robot("two_mass")
    T = robot.sample_time
    placed = place_effects(robot, [parse_effect(text, "test") for text in effects])
    random, time, drive = generator(1, 600), T * np.arange(samples), np.zeros(samples)
    for frequency in np.arange(1.3, 30, 1.7):
        drive += 30 * np.sin(2 * np.pi * frequency * time + random.uniform(0, 2 * np.pi))
    plant = Plant(placed.robot, T, np.zeros(4), substeps=4, laws=placed.laws)
    position, torque = np.zeros((samples, 1)), np.zeros((samples, 1))
    for k in range(samples):
        state = plant.state
        position[k] = state[1]
        torque[k] = drive[k] + 200 * (0.5 * np.sin(2 * np.pi * 0.4 * time[k]) - state[1]) - 20 * state[3]
        plant.advance(torque[k])
    position += 1e-5 * random.standard_normal(position.shape)
    return Record("log", T, position, torque, np.ones(samples, dtype=bool), imported=True)


def search_and_fit(
    truth: tuple[str, ...], found: tuple[str, ...], rivals: tuple[str, ...] = RIVALS
) -> tuple[Search, CandidateFit]:
    """Prepare a search in such a log with numbers of the model known to 3 %, and fit some effects to it."""
    robot = load_robot("two_mass")
    model = RobotWithEffects(robot, ())
    data = fit_data(record_of(*truth, samples=FEW), model, SETTINGS)
    among = dict.fromkeys(("inertia", "stiffness", "damping"), 0.03)
    settings = SETTINGS.model_copy(update={"search": SearchSettings(effects=rivals)})
    search = prepare_search(fit_null(data, model, tolerance_of(robot, among)), settings)
    known = {one.name: one for one in search.candidates()}
    additions = search.additions(
        search.directions([known[name] for name in found]), search.null.fit, search.surroundings(search.null.fit)
    )
    return search, search.completed(search.together(search.null.fit, additions))


@pytest.mark.parametrize(
    ("effect", "size"),
    [
        ("stiffness_error@body_1.rz:relative=-0.3", "relative"),
        ("nonlinear_stiffness@body_1.rz:relative=-0.5,knee=1e-3", "relative"),
    ],
)
def test_friction_that_drowned_in_a_wrong_spring_is_found_beside_it(effect: str, size: str) -> None:
    robot = RobotWithEffects(load_robot("two_mass"), ())
    found = diagnose(record_of(*FRICTION, effect, samples=FEW), robot, settings=SETTINGS)
    causes = {f"{one.effect}@{one.location}": one for one in found.diagnosis.causes}
    name = effect.partition(":")[0]
    assert causes.keys() == {"coulomb_friction@motor_1", "viscous_friction@motor_1", name}
    assert causes["coulomb_friction@motor_1"].parameters["level"].value == pytest.approx(6, rel=0.05)
    assert causes["viscous_friction@motor_1"].parameters["coefficient"].value == pytest.approx(10, rel=0.05)
    spring = causes[name].parameters[size]
    assert spring.value == pytest.approx(float(effect.partition(f"{size}=")[2].partition(",")[0]), rel=0.05)
    assert found.diagnosis.verdict == "explained"


def test_friction_that_yields_before_it_slides_is_not_taken_for_a_rigid_one() -> None:
    """It bends by 1 mrad. Rigid friction does most of that, so that no other law comes in its place at first."""
    yields = "presliding_friction@motor_1:level=20,stiffness=2e4,damping=6"
    record = record_of(yields, FRICTION[1], samples=FEW)
    found = diagnose(record, RobotWithEffects(load_robot("two_mass"), ()), settings=SETTINGS)
    causes = {f"{one.effect}@{one.location}": one for one in found.diagnosis.causes}
    assert causes.keys() == {"presliding_friction@motor_1", "viscous_friction@motor_1"}
    friction = causes["presliding_friction@motor_1"].parameters
    assert friction["level"].value == pytest.approx(20, rel=0.05)
    assert friction["stiffness"].value == pytest.approx(2e4, rel=0.1)


@pytest.mark.parametrize(("tolerance", "shown"), [({}, True), ({"torque": 0.05}, False)])
def test_effects_below_the_tolerance_of_torques_are_found_where_nobody_stated_one(
    tolerance: dict[str, float], shown: bool
) -> None:
    """A hump of 4 % of the rms torque: with it nothing is left, so that the torques are far better than 5 %."""
    record = record_of(*FRICTION, "stribeck_friction@motor_1:extra=4,velocity=0.1")
    found = diagnose(record, RobotWithEffects(load_robot("two_mass"), ()), tolerance=tolerance, settings=SETTINGS)
    causes = {f"{one.effect}@{one.location}": one for one in found.diagnosis.causes}
    assert ("stribeck_friction@motor_1" in causes) is shown
    assert any("torques are better than the 0.05" in text for text in found.diagnosis.warnings) is shown
    level = causes["coulomb_friction@motor_1"].parameters["level"].value
    assert (level == pytest.approx(6, rel=0.02)) is shown


def test_a_gain_takes_the_place_of_a_rotor_and_a_load_that_stand_for_it() -> None:
    search, wrong = search_and_fit(
        ("torque_gain_error@motor_1:relative=0.2", FRICTION[1]),
        ("motor_inertia_error@motor_1", "payload_error@tool", "viscous_friction@motor_1"),
    )
    right = with_gains(search, wrong, [])
    assert right.names == {"torque_gain_error@motor_1", "viscous_friction@motor_1"}
    assert right.chi2 < wrong.chi2
    sizes = dict(zip((one.name for one in right.hypothesis), right.predictor.values(right.theta), strict=True))
    assert sizes["torque_gain_error@motor_1"]["relative"] == pytest.approx(0.2, rel=0.1)


def test_numbers_that_a_gain_does_not_stand_for_stay() -> None:
    truth = ("motor_inertia_error@motor_1:relative=0.2", "stiffness_error@body_1.rz:relative=-0.3", FRICTION[1])
    search, right = search_and_fit(truth, tuple(one.partition(":")[0] for one in truth))
    assert with_gains(search, right, []) is right


def test_a_stiff_spring_takes_the_place_of_hysteresis_that_bends_by_more_than_the_gear() -> None:
    truth = ("stiffness_error@body_1.rz:relative=0.4", FRICTION[1])
    search, wrong = search_and_fit(truth, ("hysteresis@motor_1", "viscous_friction@motor_1"))
    right = with_simpler_effects(search, wrong, [])
    assert right.names == {"stiffness_error@body_1.rz", "viscous_friction@motor_1"}


def test_a_number_takes_the_place_of_a_rich_law_that_does_no_more_than_its_parameters_by_chance() -> None:
    truth = ("stiffness_error@body_1.rz:relative=0.4", FRICTION[1])
    search, wrong = search_and_fit(truth, ("hysteresis@motor_1", "viscous_friction@motor_1"))
    least = with_simpler_effects(search, wrong, []).chi2
    for ahead, taken in ((5.0, True), (50.0, False)):
        rich = replace(wrong, chi2=least - ahead)
        assert (with_simpler_effects(search, rich, []) is not rich) is taken


def test_a_wrong_stiffness_takes_the_place_of_a_spring_with_a_knee_beside_backlash() -> None:
    truth = ("stiffness_error@body_1.rz:relative=0.25", "backlash@motor_1:gap=1e-3", FRICTION[1])
    found = ("backlash@motor_1", "viscous_friction@motor_1", "nonlinear_stiffness@body_1.rz")
    search, wrong = search_and_fit(truth, found)
    right = with_simpler_effects(search, wrong, [])
    assert right.names == {"stiffness_error@body_1.rz", *found[:2]}
    sizes = dict(zip([one.effect.name for one in right.hypothesis], right.predictor.values(right.theta), strict=True))
    assert sizes["stiffness_error"]["relative"] == pytest.approx(0.25, abs=0.06)  # two tolerances of the stiffness
    assert sizes["backlash"]["gap"] == pytest.approx(1e-3, rel=0.02)


def test_a_spring_with_a_knee_that_is_worth_it_stays() -> None:
    truth = ("nonlinear_stiffness@body_1.rz:relative=0.6,knee=2e-3", FRICTION[1])
    search, right = search_and_fit(truth, ("nonlinear_stiffness@body_1.rz", "viscous_friction@motor_1"))
    assert with_simpler_effects(search, right, []) is right


def test_backlash_takes_the_place_of_a_curve_that_stands_for_it(monkeypatch: pytest.MonkeyPatch) -> None:
    curves = (*RIVALS, "spring_curve")
    truth = ("backlash@motor_1:gap=1e-3", FRICTION[1])
    search, friction = search_and_fit(truth, ("viscous_friction@motor_1",), curves)
    wrong = with_curves(search, friction, [], [], {"spring_curve@body_1.rz"})
    assert wrong.names == {"spring_curve@body_1.rz", "viscous_friction@motor_1"}
    right = with_simpler_effects(search, wrong, [])
    assert right.names == {"backlash@motor_1", "viscous_friction@motor_1"}
    assert right.chi2 < wrong.chi2
    curve = replace(wrong, chi2=0.9 * right.chi2)  # as of one that takes up what else is missing
    for worth in (True, False):
        monkeypatch.setattr(richer_laws, "worth", lambda *_, worth=worth: worth)
        assert (with_simpler_effects(search, curve, []) is curve) is worth


def test_hysteresis_that_no_number_stands_for_stays() -> None:
    truth = ("hysteresis@motor_1:level=20,angle=1e-3", FRICTION[1])
    search, right = search_and_fit(truth, ("hysteresis@motor_1", "viscous_friction@motor_1"))
    assert with_simpler_effects(search, right, []) is right


def test_friction_that_yields_stays_without_a_hump_that_ended_at_a_limit() -> None:
    yields = "presliding_friction@motor_1:level=20,stiffness=2e4,damping=6"
    search, found = search_and_fit((yields, FRICTION[1]), ("presliding_friction@motor_1", "viscous_friction@motor_1"))
    pruned = search.pruned(found)
    (law,) = (one for one in pruned.hypothesis if one.name == "presliding_friction@motor_1")
    assert {free.name for free in law.free} <= {"level", "stiffness", "damping"}  # there is no hump
    theta = found.theta.copy()
    for column, free in enumerate(free for one in found.hypothesis for free in one.free):
        if free.name in ("extra", "velocity"):  # a high hump that is too narrow to be seen
            theta[column] = free.bounds[free.name == "extra"]
    right = search.within_limits(replace(found, theta=theta))
    assert right.names == found.names
    assert not at_limits(right)
    assert right.chi2 == pytest.approx(found.chi2, rel=0.02)


def test_a_load_takes_the_place_of_a_gain_with_all_else_in_proportion() -> None:
    """Friction, springs and dampers of the one are those of the other one, times the gain."""
    load, gain = "payload_error@tool", "torque_gain_error@motor_1"
    search, wrong = search_and_fit(
        (f"{load}:relative=0.3", *FRICTION), (gain, *(one.partition(":")[0] for one in FRICTION))
    )
    fits: list[CandidateFit] = []
    assert with_common_scale(search, wrong, fits) is wrong
    (right,) = (fit for fit in fits if load in fit.names)
    assert right.names == wrong.names - {gain} | {load}
    assert right.chi2 < wrong.chi2
    sizes = dict(zip((one.name for one in right.hypothesis), right.predictor.values(right.theta), strict=True))
    assert sizes[load]["relative"] == pytest.approx(0.3, rel=0.1)
    assert sizes["coulomb_friction@motor_1"]["level"] == pytest.approx(6, rel=0.05)
