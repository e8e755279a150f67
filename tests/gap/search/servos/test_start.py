"""Servos: gains, limits and friction are fitted at once before the search."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexros.effects import RobotWithEffects, parse_effect, place_effects
from flexros.effects.counterbalance import Counterbalance
from flexros.effects.left_out import ToolLoad
from flexros.gap.candidates.candidate import Candidate
from flexros.gap.candidates.tolerance import tolerance_of
from flexros.gap.checked_log import checked_log
from flexros.gap.diagnose import diagnose
from flexros.gap.fit.candidate_fit import CandidateFit, first_parameters
from flexros.gap.fit.null_fit import NullFit, fit_null
from flexros.gap.fit.sum_of_squares import chi2_of
from flexros.gap.fit.torques.regression import regress_torque
from flexros.gap.residuals.prepare_fit_data import fit_data
from flexros.gap.search.servos import start
from flexros.gap.search.servos.fits import ServoFits
from flexros.gap.search.servos.plan import Begun, begun_of, limited_servos, moved_from_zero
from flexros.gap.search.servos.start import fit_of_servos
from flexros.gap.settings import DiagnosisSettings, SearchSettings
from flexros.logs.stamps import stamps_ns
from flexros.logs.time_series import JointSeries, Log
from flexros.record.record import Record
from flexros.robot import Robot
from flexros.simulate.plant import Plant
from tests.gap.diagnosis_logs import settings_of
from tests.gap.servo_logs import NOISE, ONE, SERVO_EFFECTS, T, servo_arm, servo_log, servo_robot

pytestmark = pytest.mark.slow

DELAY, LAG_1, LAG_2 = "delay@all", "servo_command_lag@motor_1", "servo_command_lag@motor_2"
LIMIT = 6.0
MODEL = RobotWithEffects(servo_robot(limit=LIMIT), ())
HOBBY = (
    "servo_stiffness_error@motor_1:relative=1.0",
    "servo_damping_error@motor_1:relative=-0.85",
    "torque_gain_error@motor_1:relative=0.4",
    "viscous_friction@motor_1:coefficient=1.2",
    "coulomb_friction@motor_1:level=0.25",
)
"""A servo whose damping is the back-EMF behind its limit, unlike that of its model."""


@cache
def steps(*effects: str, seed: int = 0) -> Record:
    """A log of commanded steps."""
    rng = np.random.default_rng(seed)
    placed = place_effects(
        servo_robot(limit=LIMIT).commanded_by("position"), [parse_effect(one, "x") for one in effects]
    )
    wanted = np.repeat([0.0, *rng.uniform(-1.2, 1.2, 30)], 100)[:, None]  # it begins upright, without torque
    plant = Plant(placed.robot, T, placed.robot.equilibrium([0.0]), laws=placed.laws, torque=wanted[0], substeps=8)
    position = np.empty_like(wanted)
    for k, row in enumerate(wanted):
        position[k] = plant.measure()
        plant.advance(row)
    position += NOISE * rng.normal(size=position.shape)
    stamp = stamps_ns(len(wanted), T)
    log = Log(JointSeries(stamp, ONE, position=position), JointSeries(stamp, ONE, position=wanted))
    return replace(checked_log(log, MODEL.robot, name="log"), imported=True)


@cache
def null() -> NullFit:
    model = replace(MODEL, robot=MODEL.robot.commanded_by("position"))
    return fit_null(fit_data(steps(*HOBBY), model, DiagnosisSettings()), model, tolerance_of(model.robot, {}))


def sizes_of(found: CandidateFit) -> dict[str, float]:
    values = found.predictor.values(found.theta)
    return {one.effect.name: next(iter(own.values())) for one, own in zip(found.hypothesis, values, strict=True)}


def found_in_arm(arm: Callable[[], Robot], *hidden: str) -> dict[str, dict[str, float]]:
    """Values by effect@location of the fits with which the search in a log of an arm with hidden effects begins."""
    record = replace(checked_log(servo_log(*hidden, robot=arm), arm(), name="log"), imported=True)
    model = RobotWithEffects(arm().commanded_by("position"), ())
    nominal = fit_null(fit_data(record, model, DiagnosisSettings()), model, tolerance_of(model.robot, {}))
    found = fit_of_servos(nominal, None, DiagnosisSettings())
    assert found is not None
    values = zip(found.hypothesis, found.predictor.values(found.theta), strict=True)
    return {one.name: dict(own) for one, own in values}


def test_steps_reach_the_limit_and_slow_motion_does_not() -> None:
    assert limited_servos(MODEL.robot, steps(*HOBBY), 0.01).tolist() == [True]
    slow = checked_log(servo_log(), servo_robot(), name="log")
    assert limited_servos(servo_robot(), slow, 0.01).tolist() == [False]


def test_all_numbers_of_a_hobby_servo_are_found() -> None:
    told: list[tuple[str, float]] = []
    found = fit_of_servos(null(), None, DiagnosisSettings(), progress=lambda step, share: told.append((step, share)))
    assert {step for step, _ in told} == {"servos"}
    shares = [share for _, share in told]
    assert shares[0] == 0.0
    assert shares == sorted(shares)
    assert 0.5 < shares[-1] < 1.0
    assert found is not None
    assert found.chi2 < 2 * null().data.n_values
    sizes = sizes_of(found)
    assert sizes["servo_stiffness_error"] == pytest.approx(1.0, abs=0.15)
    assert sizes["servo_damping_error"] == pytest.approx(-0.85, abs=0.1)
    assert sizes["torque_gain_error"] == pytest.approx(0.4, abs=0.1)
    assert sizes["viscous_friction"] == pytest.approx(1.2, rel=0.1)
    assert sizes["coulomb_friction"] == pytest.approx(0.25, rel=0.3)


def test_once_the_time_is_over_no_further_start_is_fitted() -> None:
    told = []
    found = fit_of_servos(null(), None, DiagnosisSettings(), lambda: True, lambda *step: told.append(step))
    assert told == [("servos", 0.0)]
    assert found is not None
    assert found.iterations == 1


def test_effects_that_do_not_compete_are_left_out() -> None:
    one = DiagnosisSettings(search=SearchSettings(effects=("coulomb_friction",)))
    found = fit_of_servos(null(), None, one)
    assert found is not None
    assert found.names == {"coulomb_friction@motor_1"}
    assert fit_of_servos(null(), None, DiagnosisSettings(search=SearchSettings(effects=("backlash",)))) is None


def test_the_diagnosis_names_them_and_the_repair_holds_on_another_log() -> None:
    result = diagnose(steps(*HOBBY), MODEL, holdout=steps(*HOBBY, seed=5), settings=settings_of(*SERVO_EFFECTS))
    causes = {cause.effect for cause in result.diagnosis.causes if cause.probability > 0.5}
    assert causes == {one.partition("@")[0] for one in HOBBY}
    assert result.diagnosis.gap.closed_fraction == pytest.approx(1.0, abs=0.01)


def test_a_right_servo_at_its_limit_has_no_gap() -> None:
    result = diagnose(steps(), MODEL, holdout=steps(seed=5), settings=settings_of(*SERVO_EFFECTS))
    assert result.diagnosis.verdict == "no_gap"


def test_noise_that_biases_a_regression_leaves_gains_and_damping_right() -> None:
    effects = ("viscous_friction@motor_1:coefficient=-0.25", "coulomb_friction@motor_1:level=0.25")
    robot = servo_robot()
    record = checked_log(servo_log(*effects, noise=2e-2, duration=12.0), robot, name="log")
    record = replace(record, imported=True)
    model = RobotWithEffects(robot.commanded_by("position"), ())
    regression = regress_torque(record, model, tolerance_of(model.robot, {}))
    assert regression is not None
    assert regression.servo_stiffness[0] < -0.1
    noisy = fit_null(fit_data(record, model, DiagnosisSettings()), model, tolerance_of(model.robot, {}))
    found = fit_of_servos(noisy, None, DiagnosisSettings())
    assert found is not None
    sizes = sizes_of(found)
    assert sizes["servo_stiffness_error"] == pytest.approx(0.0, abs=0.02)
    assert sizes["coulomb_friction"] == pytest.approx(0.25, rel=0.25)
    assert sizes["viscous_friction"] == pytest.approx(-0.25, abs=0.04)


def test_damping_below_that_of_the_file_is_no_friction() -> None:
    effects = ("servo_stiffness_error@motor_1:relative=-0.3", "servo_damping_error@motor_1:relative=-0.4")
    robot = servo_robot()
    record = replace(checked_log(servo_log(*effects), robot, name="log"), imported=True)
    model = RobotWithEffects(robot.commanded_by("position"), ())
    nominal = fit_null(fit_data(record, model, DiagnosisSettings()), model, tolerance_of(model.robot, {}))
    found = fit_of_servos(nominal, None, DiagnosisSettings())
    assert found is not None
    sizes = sizes_of(found)
    assert sizes["servo_stiffness_error"] == pytest.approx(-0.3, abs=0.01)
    assert sizes["servo_damping_error"] == pytest.approx(-0.4, abs=0.02)
    assert "viscous_friction" not in sizes


def test_the_regression_of_a_servo_of_known_gains_leaves_them() -> None:
    robot = servo_robot(known=True)
    record = checked_log(servo_log("coulomb_friction@motor_1:level=0.25", noise=2e-2, duration=12.0), robot, name="log")
    model = RobotWithEffects(robot.commanded_by("position"), ())
    regression = regress_torque(replace(record, imported=True), model, tolerance_of(model.robot, {}))
    assert regression is not None
    assert regression.servo_stiffness[0] == 0.0


@pytest.mark.parametrize(
    ("late", "other"),
    [("servo_command_lag@motor_1:time_constant=0.03", "delay"), ("delay@all:time=0.014", "servo_command_lag")],
)
def test_a_servo_begins_with_the_filter_or_the_delay_of_its_commands_that_the_log_shows(late: str, other: str) -> None:
    robot = servo_robot()
    friction = "coulomb_friction@motor_1:level=0.3"
    record = replace(checked_log(servo_log(late, friction), robot, name="log"), imported=True)
    model = RobotWithEffects(robot.commanded_by("position"), ())
    nominal = fit_null(fit_data(record, model, DiagnosisSettings()), model, tolerance_of(model.robot, {}))
    found = fit_of_servos(nominal, None, DiagnosisSettings())
    assert found is not None
    sizes = sizes_of(found)
    assert other not in sizes
    assert sizes[late.partition("@")[0]] == pytest.approx(float(late.partition("=")[2]), rel=0.02)
    assert sizes["coulomb_friction"] == pytest.approx(0.3, rel=0.1)


def test_a_load_that_the_file_leaves_out_is_found_beside_late_commands() -> None:
    """Without the load, wrong rotors and filters of the commands took up what it does."""
    hidden = ("tool_load@tool:mass=0.4,z=0.25", "delay@all:time=0.01", "motor_inertia_error@motor_2:relative=0.4")
    values = found_in_arm(servo_arm, *hidden)
    assert values["tool_load@tool"]["mass"] == pytest.approx(0.4, rel=0.1)
    assert values["tool_load@tool"]["z"] == pytest.approx(0.25, rel=0.1)
    assert values["delay@all"]["time"] == pytest.approx(0.01, rel=0.05)
    assert not any(name.startswith("servo_command_lag") for name in values)
    assert values["motor_inertia_error@motor_2"]["relative"] == pytest.approx(0.4, abs=0.1)


def test_a_counterbalance_is_found_where_gains_had_stood_for_it() -> None:
    hidden = (
        "counterbalance@motor_1:cosine=-1.5,sine=-2.5",
        "delay@all:time=0.01",
        "coulomb_friction@motor_2:level=0.2",
    )
    values = found_in_arm(servo_arm, *hidden)
    assert values["counterbalance@motor_1"] == pytest.approx({"cosine": -1.5, "sine": -2.5}, rel=0.1)
    assert values["delay@all"]["time"] == pytest.approx(0.01, rel=0.02)
    assert {"counterbalance@motor_2", "tool_load@tool"}.isdisjoint(values)


def test_rotors_and_a_load_that_the_file_leaves_out_are_found_beside_a_wrong_gain() -> None:
    """Filters of the commands took up the delay where logarithms of rotors had moved far down and did not come back."""
    hidden = (
        *("tool_load@tool:mass=0.4,z=0.25", "delay@all:time=0.01", "servo_stiffness_error@motor_1:relative=0.25"),
        *("rotor_inertia@motor_1:added=0.08", "rotor_inertia@motor_2:added=0.03"),
    )
    values = found_in_arm(partial(servo_arm, rotors=False), *hidden)
    assert values["tool_load@tool"]["mass"] == pytest.approx(0.4, rel=0.02)
    assert values["delay@all"]["time"] == pytest.approx(0.01, rel=0.01)
    assert values["rotor_inertia@motor_1"]["added"] == pytest.approx(0.08, rel=0.02)
    assert values["rotor_inertia@motor_2"]["added"] == pytest.approx(0.03, rel=0.02)
    assert values["servo_stiffness_error@motor_1"]["relative"] == pytest.approx(0.25, abs=0.01)


def test_parameters_are_those_of_the_search_again() -> None:
    found = fit_of_servos(null(), None, DiagnosisSettings())
    assert found is not None
    assert [free.name for one in found.hypothesis for free in one.free if free.signed and free.negative == 0.0] == []
    assert found.chi2 == pytest.approx(float(chi2_of(found.predictor, null().data, found.theta[:, None])[0]))


@pytest.mark.parametrize(
    ("best", "loaded", "taken"), [(3.0, 2.5, True), (3.0, 2.7, False), (0.8, 0.4, True), (0.8, 0.6, False)]
)
def test_a_load_must_remove_a_good_part_also_within_the_floor(best: float, loaded: float, *, taken: bool) -> None:
    """Gains and inertias of five servos left less than tolerances allow for, and half of that beside the load."""
    assert takes(Candidate(ToolLoad, "tool", ()), best, loaded) == taken


@pytest.mark.parametrize(("best", "taken"), [(3.0, True), (0.8, False)])
def test_no_counterbalance_is_sought_within_the_floor(best: float, *, taken: bool) -> None:
    """One at every joint of an arm of six servos had taken up what wrong gains left, and a rotor had gone for them."""
    assert takes(Candidate(Counterbalance, "motor_1", ()), best, 0.3 * best) == taken


def takes(one: Candidate, best: float, beside: float) -> bool:
    """Whether an effect of the carried weight is taken that lowers the mean square of the best fit to another one."""
    n = 1000
    before, after = (SimpleNamespace(chi2=level * n, names=frozenset[str]()) for level in (best, beside))
    fits: Any = SimpleNamespace(
        over=False,
        null=SimpleNamespace(data=SimpleNamespace(n_values=n)),
        settings=DiagnosisSettings(),
        likeliest=lambda found: found[0],
        screened=lambda *_: after,
        longer=lambda one: one,
        every=lambda starts, fitted, *_: [fitted(*one) for one in starts],
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(start, "first_parameters", lambda _: {})
        found = start._with_carried(fits, [before], lambda _: [], [], [(one, 0.0)])  # type: ignore[list-item]
    return found == [after]


def servo_fits(*hidden: str) -> tuple[ServoFits, Begun]:
    """Fits of a log of an arm with hidden effects, and all effects that they begin with."""
    record = replace(checked_log(servo_log(*hidden, robot=servo_arm), servo_arm(), name="log"), imported=True)
    model = RobotWithEffects(servo_arm().commanded_by("position"), ())
    nominal = fit_null(fit_data(record, model, DiagnosisSettings()), model, tolerance_of(model.robot, {}))
    settings = DiagnosisSettings()
    begun = begun_of(nominal, np.array([False, False]), settings.servo_start)
    return ServoFits(nominal, settings, None, None), moved_from_zero(begun, record, model.robot)


@pytest.mark.parametrize(
    ("hidden", "kept"),
    [
        (("delay@all:time=0.03",), set()),
        (
            ("servo_command_lag@motor_1:time_constant=0.04", "servo_command_lag@motor_2:time_constant=0.005"),
            {LAG_1, LAG_2},
        ),
    ],
    ids=["a delay", "filters"],
)
def test_filters_that_stand_for_a_part_of_the_delay_become_it(hidden: tuple[str, ...], kept: set[str]) -> None:
    """Beside rotors that brake under strong dampers, six filters and half of the delay were the end of a valley."""
    fits, bare = servo_fits(*hidden)
    late = [(one, 0.015) for one, _ in bare if one.name in (DELAY, LAG_1, LAG_2)]
    best = fits.longer(fits.screened(late, {}), 0 if not kept else None)
    found = start._with_one_delay(fits, best, bare)
    assert found.names & {LAG_1, LAG_2} == kept
    if not kept:
        assert first_parameters(found)[DELAY] == pytest.approx(0.03, abs=0.003)
