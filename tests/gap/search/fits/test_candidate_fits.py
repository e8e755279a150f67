"""Searches: every candidate is looked at, the true one comes first, explanations are extended by others."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from flexros.effects import effects
from flexros.effects.kinds.tool_error import AbstractToolError
from flexros.errors import InputError
from flexros.gap.candidates.candidate import Candidate
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.deadline import Deadline
from flexros.gap.fit.candidate_fit import CandidateFit
from flexros.gap.fit.null_fit import fit_null
from flexros.gap.fit.sum_of_squares import chi2_of
from flexros.gap.residuals.fit_data import FitData
from flexros.gap.search.fits.additions import Addition
from flexros.gap.search.prepare import prepare_search
from flexros.gap.settings import SearchSettings
from flexros.prediction.integration_step import IntegrationSteps, substeps
from flexros.robot import load_robot
from tests.gap.diagnosis_logs import MODEL, candidates_of, data_of, predictor_of, search_of

pytestmark = pytest.mark.slow

FRICTION, SOFT = "coulomb_friction@motor_1:level=0.05", "stiffness_error@body_2.rz:relative=-0.05"
SOME = ("coulomb_friction@motor_1", "stiffness_error@body_2.rz", "motor_inertia_error@motor_1", "torque_bias@motor_1")


def names(found: list[CandidateFit]) -> list[str]:
    return [" + ".join(candidate.name for candidate in one.predictor.hypothesis) for one in found]


def test_every_effect_with_ranges_is_a_candidate_but_those_of_an_unmeasured_tool() -> None:
    search = search_of()
    listed = {one.effect.name for one in (*search.candidates(), *search.harmonics(search.null.fit))}
    possible = {one.effect.name for one in candidates_of().values()}
    of_tool = {name for name, one in effects().items() if issubclass(one, AbstractToolError)}
    assert possible - of_tool <= listed
    assert not listed & of_tool
    assert {"torque_ripple", "encoder_eccentricity", "transmission_error"} <= listed


@pytest.mark.parametrize("imported", [True, False])
def test_friction_by_the_load_behind_a_spring_is_a_candidate(imported: bool) -> None:
    """Also without gravity: without it, one case of a simulator that is not ours lost three names."""
    search = search_of()
    data = replace(search.data, record=replace(search.data.record, imported=imported))
    asked = replace(search, null=replace(search.null, data=data))
    assert "load_dependent_friction@motor_1" in {one.name for one in asked.candidates()}


def test_a_measured_torque_is_not_limited() -> None:
    search = search_of()
    data = replace(search.data, record=replace(search.data.record, measured_torque=True))
    measured = replace(search, null=replace(search.null, data=data))
    left_out = {one.name for one in search.candidates()} - {one.name for one in measured.candidates()}
    assert left_out == {"torque_saturation@motor_1"}


def test_where_no_torque_acts_none_has_a_gain_or_a_delay() -> None:
    """A pendulum that swings freely has a column of zeros: a gain of +282 % had been named, which changes nothing."""
    search = search_of()
    record = replace(search.data.record, torque=np.zeros_like(search.data.record.torque))
    swings = replace(search, null=replace(search.null, data=replace(search.data, record=record)))
    left_out = {one.effect.name for one in search.candidates()} - {one.effect.name for one in swings.candidates()}
    assert left_out == {"torque_gain_error", "torque_saturation", "actuator_lag", "delay"}


def test_behind_a_relay_no_limit_competes() -> None:
    """It would scale the whole torque: one of a tenth had been named, with masses and friction as small."""
    search = search_of()
    record = replace(search.data.record, torque=10 * np.sign(search.data.record.torque))
    relay = replace(search, null=replace(search.null, data=replace(search.data, record=record)))
    assert {one.name for one in search.candidates()} - {one.name for one in relay.candidates()} == {
        "torque_saturation@motor_1"
    }


@pytest.mark.parametrize("threads", [1, 3])
def test_the_true_effect_fits_best_with_any_number_of_threads(threads: int) -> None:
    search = replace(search_of(FRICTION), threads=threads)
    found = search.singles(search.directions([candidates_of()[name] for name in SOME]))
    assert names(found)[0] == SOME[0]
    assert sorted(names(found)) == sorted(SOME)
    sums = [one.chi2 for one in found]
    assert sums == sorted(sums)
    assert sums[0] / search.data.n_values == pytest.approx(1.0, abs=5 * np.sqrt(2 / search.data.n_values))


def test_the_second_of_two_effects_is_found_in_addition_to_the_first_which_is_not_added_twice() -> None:
    search = search_of(FRICTION, SOFT)
    singles = search.singles(search.directions([candidates_of()[name] for name in SOME]))
    directions = search.directions([candidates_of()[name] for name in SOME])
    additions = search.additions(directions, singles[0], search.surroundings(singles[0]))
    assert SOME[0] not in {addition.candidate.name for addition in additions}
    assert additions[0].candidate.name == SOME[1]
    best = search.together(singles[0], additions[:1])
    assert best.names == set(SOME[:2])
    assert best.chi2 / search.data.n_values == pytest.approx(1.0, abs=5 * np.sqrt(2 / search.data.n_values))


def test_steps_that_look_at_one_explanation_share_what_is_linear_about_it(monkeypatch: pytest.MonkeyPatch) -> None:
    search = search_of(FRICTION)
    (friction,) = search.singles(search.directions([candidates_of()[SOME[0]]]))
    around = search.surroundings(friction)
    removals = search.removals(friction, around)
    monkeypatch.setattr(FitData, "residuals", lambda *_: pytest.fail("predicted again"))
    assert search.surroundings(friction) is around
    assert search.removals(friction, around) == removals


def test_candidates_are_looked_at_with_longer_steps_which_change_their_gains_little() -> None:
    robot = load_robot("six_axis")
    assert substeps(robot, 0.004, rough=True) < 0.5 * substeps(robot, 0.004)
    search = search_of(FRICTION)
    names = ("viscous_friction@motor_1", "stiffness_error@body_2.rz", "payload_error@tool")
    among = [candidates_of()[name] for name in names]
    around = search.surroundings(search.null.fit)
    exact = search.directions(among)
    two = IntegrationSteps(2, implicit=False)
    plant = search.null.plant(among, steps=two)
    residual = search.data.residuals(search.null.predictor((), search.null.plant((), steps=two)), np.zeros((0, 1)))[
        :, 0
    ]
    steps = search.null.fit.predictor.plant.steps
    for one in exact:
        again = search._directions(search.null.fit, {steps: residual, plant.steps: residual}, (one.candidate, plant))
        np.testing.assert_allclose(around.gains(again.changes)[0], around.gains(one.changes)[0], rtol=0.02)


@pytest.mark.parametrize(
    ("effect", "size", "true"),
    [
        ("torque_saturation@motor_1:limit=9.5", "limit", 9.5),  # the largest torque of the log is 9.6 Nm
        ("damping_error@body_1.rz:relative=3", "relative", 3.0),
        ("presliding_friction@motor_1:level=0.1,extra=0.03,velocity=0.8,stiffness=40,damping=0.4", "stiffness", 40.0),
    ],
)
def test_an_effect_far_from_its_starts_is_found(effect: str, size: str, true: float) -> None:
    """Its fit is nowhere after a few iterations, but falls steeply."""
    search = search_of(effect)
    name = effect.partition(":")[0]
    among = [one for one in search.candidates() if one.location in name]
    among = [one for one in among if one.name == name or one.effect.name.endswith("friction")]
    best, *_ = search.singles(search.directions(among))
    assert best.predictor.hypothesis[0].name == name
    assert best.predictor.values(best.theta)[0][size] == pytest.approx(true, rel=0.05)


def test_a_rich_effect_that_is_no_more_than_a_simpler_one_beside_others_becomes_that_one() -> None:
    search = search_of(FRICTION, SOFT)
    rich, soft = (candidates_of()[name] for name in ("presliding_friction@motor_1", SOME[1]))
    values = {"level": 0.05, "extra": 1e-6, "velocity": 0.1, "exponent": 2.0, "stiffness": 1e5, "damping": 1e-3}
    theta = np.array([*(free.encode(values[free.name]) for free in rich.free), soft.free[0].encode(-0.05)])
    predictor = search.null.predictor((rich, soft))
    found = search.with_visible(CandidateFit(predictor, np.concatenate([theta, search.null.fit.deviations]), 1e9))
    assert {SOME[0], SOME[1]} <= found.names
    assert rich.name not in found.names
    assert found.chi2 / search.data.n_values == pytest.approx(1.0, abs=5 * np.sqrt(2 / search.data.n_values))
    level = found.predictor.values(found.theta)[[one.name for one in found.hypothesis].index(SOME[0])]["level"]
    assert level == pytest.approx(0.05, rel=0.05)


def test_sizes_of_an_addition_are_scaled_and_not_turned_around() -> None:
    friction, soft = (candidates_of()[name] for name in SOME[:2])
    level, relative = friction.free[0], soft.free[0]

    def start(candidate: Candidate, value: float, size: float) -> float:
        encoded = np.array([candidate.free[0].encode(value)])
        nothing = np.zeros(0, dtype=bool), np.zeros(0, dtype=np.float32)
        return float(Addition(candidate, 1.0, encoded, *nothing).sized(size).start[0])

    assert start(friction, 2 * level.low, 3.0) == pytest.approx(level.encode(6 * level.low))
    assert start(friction, 2 * level.low, -3.0) == pytest.approx(level.encode(level.low))
    assert start(soft, 0.01 * relative.high, -3.0) == pytest.approx(relative.encode(-0.03 * relative.high))


def test_the_nominal_model_takes_up_what_is_tolerated() -> None:
    null = fit_null(data_of(SOFT), MODEL, Tolerance(("body_2.rz.stiffness",), (0.05,)))
    assert null.fit.theta[0] == pytest.approx(-1.0, abs=0.05)


def test_of_several_fits_of_one_effect_the_best_is_carried_to_its_end() -> None:
    """A worse one, begun elsewhere, may take most of the time of a search, and ends where the best one does."""
    search = search_of(FRICTION)
    predictor = predictor_of(candidates_of()[SOME[0]])
    levels = (np.log(0.049), np.log(0.01))
    starts = [np.array([level, *np.zeros(predictor.n_fitted - 1)]) for level in levels]
    sums = chi2_of(predictor, search.data, np.stack(starts, axis=-1))
    (finished,) = search.finished([CandidateFit(predictor, *begun) for begun in zip(starts, sums)][::-1])
    assert np.exp(finished.theta[0]) == pytest.approx(0.05, rel=0.05)


def test_progress_of_each_stage_ends_with_all_of_it() -> None:
    calls: dict[str, list[float]] = {}
    search = replace(search_of(), progress=lambda stage, share: calls.setdefault(stage, []).append(share))
    search.singles(search.directions([candidates_of()[name] for name in SOME]))
    assert all(shares == sorted(shares) and shares[-1] == 1.0 for shares in calls.values())
    assert len(calls["single effects"]) == len(SOME) - 1  # after the most promising one


def test_only_the_effects_of_the_settings_compete() -> None:
    search = search_of(among=("torque_bias", "torque_ripple"))
    listed = {one.effect.name for one in (*search.candidates(), *search.harmonics(search.null.fit))}
    assert listed == {"torque_bias", "torque_ripple"}
    with pytest.raises(InputError, match="torque_bias"):
        search_of(among=("torque_bia",))


def test_only_effects_at_the_motors_of_the_settings_compete() -> None:
    """The robot has one motor: to name it is no restriction; names are checked as those of effects are."""
    search = search_of(among=("torque_bias", "delay"))
    settings = search.settings.model_copy(update={"search": SearchSettings(effects=("delay",), joints=("motor_1",))})
    assert {one.location for one in prepare_search(search.null, settings).candidates()} == {"all"}
    with pytest.raises(InputError, match="motor_1"):
        prepare_search(search.null, settings.model_copy(update={"search": SearchSettings(joints=("motor_2",))}))


def test_one_candidate_is_fitted_even_when_the_time_is_over() -> None:
    asked = [False]
    search = replace(search_of(FRICTION), deadline=Deadline(interrupted=lambda: asked[0]))
    directions = search.directions([candidates_of()[name] for name in SOME])
    asked[0] = True
    assert names(search.singles(directions)) == [SOME[0]]


@pytest.mark.parametrize(("named", "shown"), [
    (("motor_inertia_error@motor_1", "coulomb_friction@motor_1"), {"motor_inertia_error@motor_1"}),
    (("torque_gain_error@motor_1",), {"torque_gain_error@motor_1"}),
    (("torque_gain_error@motor_1", "motor_inertia_error@motor_1"), {"motor_inertia_error@motor_1"}),
])  # fmt: skip
def test_a_relative_error_that_replaces_one_that_torques_show_is_shown_as_well(
    named: tuple[str, ...], shown: set[str]
) -> None:
    search, every = search_of(), candidates_of()

    def fit(*names: str) -> CandidateFit:
        predictor = search.null.predictor(tuple(every[name] for name in names))
        return CandidateFit(predictor, np.zeros(predictor.n_effect + len(search.null.fit.deviations)), 0.0)

    assert replace(search, base=fit("motor_inertia_error@motor_1")).shown_by_torques(fit(*named)) == shown


def test_a_richer_form_begins_with_the_usual_value_of_what_is_not_free() -> None:
    """A shape that ended at a limit is no free parameter of the simpler law any more."""
    search = search_of("stribeck_friction@motor_1:extra=0.02,velocity=0.5")
    candidates = {one.name: one for one in search.candidates()}
    law, rich = (candidates[f"{name}@motor_1"] for name in ("stribeck_friction", "presliding_friction"))
    simple = law.with_usual("exponent")
    assert simple is not None
    predictor = search.null.predictor((simple,))
    theta = np.zeros(predictor.n_effect + len(search.null.fit.deviations))
    fit = CandidateFit(predictor, theta, search.null.fit.chi2)
    plants = search.plants(fit, [rich])
    begun = search.enriched(fit, simple, rich, plants[rich], -np.inf)
    assert begun is not None
    assert begun.names == {rich.name}


def test_friction_that_takes_away_that_of_the_model_has_no_richer_form() -> None:
    search = search_of()
    candidates = {one.name: one for one in search.candidates()}
    simple, rich = (candidates[f"{name}@motor_1"] for name in ("coulomb_friction", "presliding_friction"))
    less = SimpleNamespace(
        hypothesis=(simple,), theta=np.zeros(1), predictor=SimpleNamespace(values=lambda _: [{"level": -0.1}])
    )
    plant = search.null.fit.predictor.plant
    assert search.enriched(cast("CandidateFit", less), simple, rich, plant, 0.0) is None


def test_frequencies_of_an_added_mode_are_tried_close_to_each_other_beside_other_effects() -> None:
    """Of a telescope a mode of 14 Hz was tried from 11 and 19 Hz, from where no fit came to it."""
    search = search_of(FRICTION)
    friction, mode = (candidates_of()[name] for name in (SOME[0], "extra_mode@tool"))
    begun = search.together(
        search.null.fit,
        search.additions(search.directions([friction]), search.null.fit, search.surroundings(search.null.fit)),
    )
    for fit in (search.null.fit, begun):
        (one,) = search.directions([mode], fit)
        column = [free.name for free in mode.free].index("frequency")
        frequencies = np.unique(np.exp(one.starts[column]))
        assert np.max(frequencies[1:] / frequencies[:-1]) < 1.2
