"""Fitted parameters in the units of their effects, with their covariance."""

from __future__ import annotations

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from flexros.effects import RobotWithEffects, effects
from flexros.gap.candidates.candidate import Candidate, free_parameter
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.diagnose import diagnose
from flexros.gap.fit import estimates
from flexros.gap.fit.candidate_fit import CandidateFit
from flexros.gap.fit.doubts import doubt_of
from flexros.gap.fit.estimates import (
    clearness,
    covariance_of,
    fit_covariance,
    parameters_of,
    placed_effects,
    smoothed,
    unit_of_parameter,
)
from flexros.gap.fit.initial_values import initial_values
from flexros.gap.fit.least_squares import fit
from flexros.gap.fit.sum_of_squares import chi2_of
from flexros.gap.schema import CauseParameter
from flexros.gap.settings import FitSettings, RankingSettings
from flexros.random_streams import generator
from flexros.robot import load_robot
from tests.gap.diagnosis_logs import WHOLE, candidates_of, data_of, encoded, predictor_of, settings_of
from tests.gap.rigid_arm import COULOMB, arm, record_of_arm

pytestmark = pytest.mark.slow

LEVEL = 0.03


@pytest.fixture(name="fitted", scope="module")
def fitted_fixture() -> CandidateFit:
    """Coulomb friction by its logarithm, known to 10 %, and a stiffness to 0.02, and a tolerated parameter."""
    pair = [candidates_of()[name] for name in ("coulomb_friction@motor_1", "stiffness_error@body_2.rz")]
    predictor = predictor_of(*pair, tolerance=Tolerance(("body_1.rz.stiffness",), (0.02,)))
    theta = np.array([*encoded(pair[0], level=0.05), *encoded(pair[1], relative=-0.1), 0.5])
    scale = np.array([0.1, 0.02 / pair[1].free[0].high, 0.8])
    correlation = np.array([[1.0, 0.5, 0.2], [0.5, 1.0, 0.1], [0.2, 0.1, 1.0]])
    return CandidateFit(predictor, theta, 1.0, np.linalg.inv(correlation * np.outer(scale, scale)))


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


def test_deviations_of_a_fit_that_nearly_diverges_are_finite(
    fitted: CandidateFit, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(estimates, "smoothed", lambda power: np.full_like(power, np.inf))
    data = data_of()
    with np.errstate(invalid="ignore"):
        (friction, _) = parameters_of(replace(fitted), data)
    assert np.isfinite(friction["level"].std)


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


def test_a_phase_is_known_as_well_at_zero() -> None:
    ranges = effects()["torque_ripple"].ranges
    free = tuple(free_parameter(name, ranges[name], 1.0) for name in ("amplitude", "phase"))
    ripple = Candidate(effects()["torque_ripple"], "motor_1", free, (("order", 6.0),))
    theta = np.array(encoded(ripple, amplitude=0.1, phase=0.0))
    (found,) = parameters_of(CandidateFit(predictor_of(ripple), theta, 1.0, 1e4 * np.eye(len(theta))))
    assert found["phase"].std > found["phase"].value == 0.0
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


def test_smoothed_white_periodogram_is_flat() -> None:
    power = generator(3, 900).exponential(size=20_000)
    flat = smoothed(power)
    assert flat.mean() == pytest.approx(1.0, abs=0.03)
    assert np.abs(flat[5_000:] - 1.0).max() < 0.15


def test_smoothing_keeps_a_step_at_low_frequency() -> None:
    power = np.where(np.arange(20_000) < 40, 0.01, 1.0)
    assert smoothed(power)[:30].max() < 0.1


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


def test_model_form_errors_of_effects_widen_the_deviations_of_all_sizes() -> None:
    """A large effect of slightly other form than the true one moves the small one that is fitted beside it."""
    large = [f"coulomb_friction@motor_1:level={LEVEL}", "torque_bias@motor_1:level=0.001"]
    among = candidates_of(*large)
    pair = [among["coulomb_friction@motor_1"], among["torque_bias@motor_1"]]
    data = data_of(*large)
    predictor = predictor_of(*pair)
    start = np.array([*encoded(pair[0], level=LEVEL), *encoded(pair[1], level=0.001)])
    found = fit(predictor, data, start, 20, enough=FitSettings().exactly)

    def deviations(form: RankingSettings | None) -> list[float]:
        return [next(iter(one.values())).std for one in parameters_of(found, data, form)]

    assert np.all(np.array(deviations(RankingSettings())) > deviations(None))
    limited, free = (RankingSettings(form_over_rest=most) for most in (0.1, 1e9))  # what is left limits them
    assert np.all(np.array(deviations(limited)) < deviations(free))
    without = RankingSettings(plain_form=0.0, shaped_form=0.0)
    np.testing.assert_allclose(deviations(without), deviations(None))


def test_sizes_of_hysteresis_allow_for_laws_of_other_shapes_on_measured_logs() -> None:
    """Sizes that move with the shape are known no better than laws such as that of Dahl leave them."""
    entry = "hysteresis@motor_1:level=2e-3,angle=1e-4,spread=1.0"
    candidate = candidates_of(entry)["hysteresis@motor_1"]
    data = data_of(entry, length=WHOLE)
    start = np.array(encoded(candidate, level=2e-3, angle=1e-4, spread=1.0))
    found = fit(predictor_of(candidate), data, start, 3, enough=FitSettings().exactly)
    measured = replace(data, record=replace(data.record, imported=True))
    (ours,), (theirs,) = (parameters_of(found, one, RankingSettings()) for one in (data, measured))
    assert theirs["spread"].std == pytest.approx(0.5, rel=0.05)
    assert theirs["angle"].std > 1.4 * ours["angle"].std


def test_friction_that_grows_is_known_no_better_on_a_measured_log_than_it_varies() -> None:
    """One level for all of a log on which it rises by a half is right nowhere, however long the log is."""
    level, drift = f"coulomb_friction@motor_1:level={LEVEL}", f"coulomb={0.5 * LEVEL},time_constant=4"
    candidate = candidates_of(level)["coulomb_friction@motor_1"]
    start, widths = np.array(encoded(candidate, level=1.3 * LEVEL)), []
    for effects_of_log in ((level,), (level, f"friction_drift@motor_1:{drift}")):
        data = data_of(*effects_of_log)
        found = fit(predictor_of(candidate), data, start, 20, enough=FitSettings().exactly)
        measured = replace(data, record=replace(data.record, imported=True))
        widths.append(parameters_of(found, measured, RankingSettings())[0]["level"].std / LEVEL)
    steady, rising = widths
    assert steady < 0.02
    assert 0.04 < rising < 0.5


def test_a_size_that_the_whole_log_shows_stays_determined(monkeypatch: pytest.MonkeyPatch) -> None:
    """Parts may tell next to nothing where sizes have a common factor; the whole log says that the effect is there."""
    candidate = candidates_of(f"coulomb_friction@motor_1:level={LEVEL}")["coulomb_friction@motor_1"]
    data = data_of(f"coulomb_friction@motor_1:level={LEVEL}")
    found = fit(predictor_of(candidate), data, np.array(encoded(candidate, level=LEVEL)), 20)
    monkeypatch.setattr(estimates, "variation_between_parts", lambda *_: np.array([np.inf]))
    measured = replace(data, record=replace(data.record, imported=True))
    size = parameters_of(found, measured, RankingSettings())[0]["level"]
    assert size.determined
    assert size.std == pytest.approx(0.9 * size.value)


def test_a_number_that_a_log_says_nothing_of_keeps_its_tolerance_however_the_prior_weighs(
    fitted: CandidateFit, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The prior of a measured log weighs as much as what first effects leave: a gain was 10 times too certain."""
    data = data_of()
    rng, rows = np.random.default_rng(1), data.spread.size
    J = np.column_stack([rng.standard_normal((rows, 2)), np.zeros(rows)])
    for misfit in (1.0, 100.0):
        line = SimpleNamespace(slopes=J, residual=np.zeros(rows), information=J.T @ J + np.diag([0.0, 0.0, misfit]))
        monkeypatch.setattr(estimates, "linearised", lambda *_, line=line: line)
        assert np.sqrt(fit_covariance(replace(fitted), replace(data), None)[2, 2]) == pytest.approx(1.0)


def test_tolerated_numbers_that_are_not_fitted_widen_the_sizes_that_they_look_like() -> None:
    """No log informs of the inertia of a body beside that of a rotor at low frequency, and the rotor seemed certain."""
    candidate, data, form = candidates_of()["motor_inertia_error@motor_1"], data_of(), RankingSettings()
    names, theta = ("body_1.inertia.zz", "body_1.mass"), encoded(candidate, relative=0.2)
    widths = []
    for directions in (np.eye(2), np.empty((2, 0))):
        predictor = predictor_of(candidate, tolerance=Tolerance(names, (0.1, 0.1), directions=directions))
        whole = np.array([*theta, *np.zeros(predictor.tolerance.n_free)])
        fit = CandidateFit(predictor, whole, float(chi2_of(predictor, data, whole[:, None])[0]))
        widths.append([parameters_of(fit, data, one)[0]["relative"].std for one in (form, None)])
    (fitted, _), (considered, ignored) = widths
    assert considered > 0.9 * fitted
    assert considered > 1.5 * ignored


def test_a_shift_in_time_is_a_doubt_where_the_errors_show_it_or_leave_it_open() -> None:
    rng = np.random.default_rng(2)
    J, other = rng.standard_normal((500, 1)), rng.standard_normal(500)
    inverse = np.linalg.inv(J.T @ J)
    alike, unlike = J[:, 0], J[:, 0] + 5 * (other - J[:, 0] * (J[:, 0] @ other) / (J[:, 0] @ J[:, 0]))
    whole = float((J[:, 0] @ J[:, 0]) ** 2)
    left_open = doubt_of(alike, J, np.zeros(500), inverse)
    excluded = doubt_of(unlike, J, np.zeros(500), inverse)
    shown = doubt_of(unlike, J, unlike - alike, inverse)
    assert left_open[0, 0] == pytest.approx(whole)
    assert excluded[0, 0] < 1e-3 * whole
    assert shown[0, 0] == pytest.approx(whole, rel=0.01)
    of_another_cause = doubt_of(unlike, J, 10 * (unlike - alike), inverse)  # 1.4 samples are no half sample
    assert of_another_cause[0, 0] == pytest.approx(3 * whole, rel=0.01)


@pytest.mark.parametrize(("rise", "widest"), [(0.0, 0.02), (0.02, 0.1)])
def test_friction_that_rises_smoothly_is_within_its_interval(rise: float, widest: float) -> None:
    """Taken for a jump, its level comes out too small; without a rise the interval stays narrow."""
    names = ("coulomb_friction", "viscous_friction")
    found = diagnose(record_of_arm(imported=True, rise=rise), RobotWithEffects(arm(), ()), settings=settings_of(*names))
    sizes = {one.location: one.parameters["level"] for one in found.diagnosis.causes if one.effect == names[0]}
    for location, true in zip(("motor_1", "motor_2"), COULOMB, strict=True):
        assert abs(sizes[location].value - true) < 2 * sizes[location].std
        assert sizes[location].std < widest * true
