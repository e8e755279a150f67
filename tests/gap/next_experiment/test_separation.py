"""The most easily confused pairs: the diagnosis experiment separates them, each at its best fit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.effects import RobotWithEffects, parse_effect
from flexros.effects.kinds.ranges import Range
from flexros.effects.motor_inertia_error import MotorInertiaError
from flexros.effects.torque_bias import TorqueBias
from flexros.errors import InputError
from flexros.gap.candidates.candidate import list_candidates
from flexros.gap.candidates.scales import scales_of
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.fit.candidate_fit import best_of
from flexros.gap.fit.initial_values import initial_values
from flexros.gap.fit.least_squares import fit
from flexros.gap.fit.sum_of_squares import chi2_of
from flexros.gap.next_experiment.separation import ROOM, Explained, Trial, _free, predictor_of, separation, trial
from flexros.gap.prediction.predictor import Predictor
from flexros.gap.settings import DiagnosisSettings, FitSettings, RankingSettings
from flexros.robot import load_robot

pytestmark = pytest.mark.slow

KEYS = {"diagnosis.length": 10, "diagnosis.poses": 1}
SAMPLE_TIME = 5e-4


def explained(text: str = "", name: str = "four_mass_linear") -> Explained:
    model = RobotWithEffects(load_robot(name), ())
    return Explained(model, (parse_effect(text, "test"),) if text else ())


def chi2(one: Explained, made: Trial) -> float:
    predictor, theta = predictor_of(one, SAMPLE_TIME)
    return float(chi2_of(predictor, made.data, theta[:, None])[0])


def best_chi2(rival: str, made: Trial, model: RobotWithEffects) -> float:
    """Fit an effect from all starts of its ranges."""
    nothing, _ = predictor_of(Explained(model, ()), SAMPLE_TIME)
    seen = nothing.predict(np.zeros((0, 1)), made.record, made.data.gain, made.data.initial_state, record_states=True)
    assert seen.states is not None
    sizes = scales_of(model.robot, seen.states[:, :, 0], made.record.torque)
    candidate = next(one for one in list_candidates(model.robot, sizes) if one.name == rival)
    predictor = Predictor(model, (candidate,), Tolerance(), SAMPLE_TIME)
    starts = initial_values(predictor)
    order = np.argsort(chi2_of(predictor, made.data, starts))[:2]
    return best_of([fit(predictor, made.data, starts[:, place]) for place in order]).chi2


@pytest.mark.parametrize(
    ("truth", "rival"),
    [
        ("backlash@motor_1:gap=1e-4", "hysteresis@motor_1"),
        ("hysteresis@motor_1:level=0.004,angle=5e-4", "backlash@motor_1"),
        ("backlash@motor_1:gap=1e-4", "coulomb_friction@motor_1"),
        ("motor_inertia_error@motor_1:relative=0.001", "torque_gain_error@motor_1"),
        ("torque_gain_error@motor_1:relative=0.001", "motor_inertia_error@motor_1"),
        ("coulomb_friction@motor_1:level=0.01", "stribeck_friction@motor_1"),
        ("stribeck_friction@motor_1:extra=0.01,velocity=1", "coulomb_friction@motor_1"),
        ("stiffness_error@body_1.rz:relative=0.002", "payload_error@tool"),
        ("payload_error@tool:relative=0.002", "stiffness_error@body_3.rz"),
        ("delay@all:time=4e-4", "actuator_lag@motor_1"),
    ],
)
def test_hard_pair_is_told_apart(truth: str, rival: str) -> None:
    """Effects far below what a user would notice, a tenth of the encoder noise or a thousandth of the torque limit."""
    true = explained(truth)
    made = trial(true, KEYS, 7)
    least = chi2(true, made)
    assert least / made.data.n_values == pytest.approx(1.0, abs=0.02)  # the log is that of this truth
    assert 0.5 * (best_chi2(rival, made, true.model) - least) > 30.0  # nats; 3 would do for a factor of 20


def test_load_and_stiffness_of_two_links_under_gravity_are_told_apart() -> None:
    true = explained("payload_error@tool:relative=0.002", "elbow")
    made = trial(true, KEYS, 7)
    assert 0.5 * (best_chi2("stiffness_error@body_2.ry", made, true.model) - chi2(true, made)) > 100.0


@pytest.mark.parametrize(
    "settings",
    [
        DiagnosisSettings(fit=FitSettings(longest_step=1e-6)),  # the rival stays where it begins
        DiagnosisSettings(ranking=RankingSettings(shaped_form=0.0, plain_form=0.0)),
    ],
)
def test_a_rival_is_fitted_and_ranked_by_the_settings_of_the_diagnosis(settings: DiagnosisSettings) -> None:
    texts = "coulomb_friction@motor_1:level=0.5", "viscous_friction@motor_1:coefficient=1e-3"
    true, rival = (explained(text) for text in texts)
    usual = separation(true, rival, trial(true, KEYS, 7))
    true, rival = replace(true, settings=settings), replace(rival, settings=settings)
    assert separation(true, rival, trial(true, KEYS, 7)) > 1.05 * usual


def test_an_explanation_is_not_separated_from_itself() -> None:
    true = explained("motor_inertia_error@motor_1:relative=0.003")
    assert separation(true, true, trial(true, KEYS, 3)) < 2.0


def test_a_negative_number_may_be_fitted_as_far_as_its_range_says() -> None:
    softening = explained("nonlinear_stiffness@body_1.rz:relative=-0.4,knee=1e-3")
    predictor, theta = predictor_of(softening, SAMPLE_TIME)
    (free,) = (one for one in predictor.hypothesis[0].free if one.name == "relative")
    place = [one.name for one in predictor.hypothesis[0].free].index("relative")
    low, _ = predictor.bounds
    assert free.decode(low[place]) == pytest.approx(-0.95)
    assert free.decode(theta[place]) == pytest.approx(-0.4)


def test_a_bound_of_negative_numbers_in_units_of_a_log_is_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    """The largest torque of the log to come is not known."""
    monkeypatch.setattr(TorqueBias, "ranges", {"level": Range("torque", 1e-3, 1.0, signed=True, negative=0.5)})
    predictor, theta = predictor_of(explained("torque_bias@motor_1:level=-2"), SAMPLE_TIME)
    low, high = predictor.bounds
    np.testing.assert_allclose(predictor.hypothesis[0].free[0].decode(low), -2.0 * ROOM)
    assert np.all((low < theta) & (theta < high))


def test_known_values_are_part_of_the_nominal_robot() -> None:
    heavier = explained("delay@all:time=1e-4").with_values({"body_3.inertia.zz": 0.03})
    assert heavier.model.robot.parameters["body_3.inertia.zz"].value == 0.03
    assert heavier.plant.robot.parameters["body_3.inertia.zz"].value == 0.03


def test_a_tool_that_is_measured_adds_to_the_separation() -> None:
    true, rival = (explained(f"kinematic_error@body_{body}:length=0.001", "elbow") for body in (1, 2))
    assert separation(true, rival, trial(true, KEYS, 3)) == pytest.approx(0.0, abs=1e-6)
    assert separation(true, rival, trial(true, KEYS, 3, tool=True)) > 100.0


def test_what_lies_within_the_tolerance_of_the_model_is_not_separated() -> None:
    """A load off by a tenth of its tolerance looks like none at all."""
    model = RobotWithEffects(load_robot("four_mass_linear"), ())
    load = (parse_effect("payload_error@tool:relative=0.002", "test"),)
    apart = []
    for tolerance in ({}, {"inertia": 0.02}):
        true, other = (Explained(model, effects, tolerance=tolerance) for effects in (load, ()))
        apart.append(separation(true, other, trial(true, KEYS, 7)))
    assert apart[0] > 1000.0
    assert apart[1] < 0.05 * apart[0]


def test_an_effect_far_above_its_range_does_not_change_its_sign_beyond_it() -> None:
    """Less than nothing is left of an inertia below -1."""
    free = _free("relative", 4.8, MotorInertiaError.ranges["relative"])
    assert free.decode(np.array(free.bounds)) == pytest.approx([-0.9, 9.0])
    assert _free("relative", -0.95, MotorInertiaError.ranges["relative"]).negative == pytest.approx(0.95)


def test_an_effect_that_takes_from_a_nominal_number_keeps_its_sign() -> None:
    """The viscous friction of emps is 203 N s/m, of which a log may show less."""
    less = Explained(
        RobotWithEffects(load_robot("emps"), ()), (parse_effect("viscous_friction@motor_1:coefficient=-50", "test"),)
    )
    predictor, theta = predictor_of(less, 1e-3)
    low, high = predictor.bounds
    assert predictor.values(theta)[0]["coefficient"] == pytest.approx(-50)
    assert np.all((low < theta) & (theta < high))
    nominal = less.model.robot.parameters["motor_1.viscous_friction"].value
    assert predictor.hypothesis[0].free[0].decode(low)[0] == pytest.approx(-nominal)


def test_a_ripple_in_proportion_to_the_torque_stays_below_it() -> None:
    """A fit that went beyond ended a whole diagnosis."""
    ripple = explained("torque_ripple@motor_1:amplitude=0.4,order=6,proportional=true")
    predictor, theta = predictor_of(ripple, SAMPLE_TIME)
    _, high = predictor.bounds
    assert predictor.hypothesis[0].placed(predictor.values(high)[0]).effect.amplitude == pytest.approx(0.99)  # type: ignore[attr-defined]
    assert predictor.values(theta)[0]["amplitude"] == pytest.approx(0.4)


def test_motors_that_hardly_accelerate_make_no_experiment() -> None:
    """One of endless inertia, whose motion was prescribed, would creep for days."""
    with pytest.raises(InputError, match="would take"):
        trial(explained().with_values({"motor_1.inertia": 1e9}), KEYS, 1)
