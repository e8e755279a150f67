"""The decision: verdict, rivals, groups and order of the effects from what was fitted."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexros.effects import RobotWithEffects, parse_effect, place_effects
from flexros.gap.answer import decision
from flexros.gap.answer.decision import (
    Findings,
    best_rival,
    effect_location,
    findings_of,
    groups_of,
    held_out_gain,
    held_out_gap,
    probability_of,
    rank_key,
    repair_of,
    verdict_of,
)
from flexros.gap.answer.warnings import _without_finding
from flexros.gap.fit.candidate_fit import CandidateFit
from flexros.gap.schema import Verdict
from flexros.gap.search.forward_selection import Explanations
from flexros.gap.search.model_probability import RANKING, compare
from flexros.record.quantization import Quantization
from tests.gap.diagnosis_logs import MODEL, ROBOT, candidates_of, data_of, encoded, predictor_of

pytestmark = pytest.mark.slow

TRUTH = "coulomb_friction@motor_1:level=0.05"
COULOMB, STIFFNESS, INERTIA = (
    "coulomb_friction@motor_1", "stiffness_error@body_2.rz", "motor_inertia_error@motor_1",
)  # fmt: skip
GAIN = "torque_gain_error@motor_1"
VALUES = {
    COULOMB: {"level": 0.05},
    STIFFNESS: {"relative": 0.03},
    INERTIA: {"relative": 0.02},
    GAIN: {"relative": -0.1},
}


def fitted(level: float, *names: str) -> CandidateFit:
    """A fit that leaves a mean squared weighted error in the fitted log."""
    hypothesis = [candidates_of()[name] for name in names]
    theta = [value for one in hypothesis for value in encoded(one, **VALUES[one.name])]
    return CandidateFit(predictor_of(*hypothesis), np.array(theta), level * data_of(TRUTH).n_values)


def findings(
    chosen: CandidateFit | None,
    rivals: list[CandidateFit],
    probabilities: list[float],
    *effects: str,
    null: float = 10.0,
    rounded: bool = False,
    model: RobotWithEffects = MODEL,
) -> Findings:
    """Findings with explanations made by hand, on logs with effects; `chosen` None for nothing."""
    data, held = (data_of(*effects, seed=seed) for seed in (1, 2))
    if rounded:
        data = replace(data, measurement=replace(data.measurement, quantizations=(Quantization(0, 1e-3),)))
    plain = fitted(null)
    fits = ([] if chosen is None else [chosen]) + rivals
    explanations = Explanations(
        compare(data, plain, fits),
        chosen or plain,
        (*fits, plain),
        np.array([*probabilities, 0.0]),
        detected=chosen is not None,
    )
    return findings_of(model, data, held, explanations)


def held_out_remainder(found: Findings) -> float:
    return found.held_comparison.remainder(found.held_chosen)


def test_nothing_left_is_no_gap_and_something_left_an_unknown_effect() -> None:
    assert verdict_of(findings(None, [], [], null=1.0)) == "no_gap"
    assert verdict_of(findings(None, [], [], null=2.0)) == "unknown_effect"


@pytest.fixture
def imitation(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the effects found have another size in every part of the log."""
    monkeypatch.setattr(
        "flexros.gap.answer.decision.constancies", lambda fit, *_: dict.fromkeys(fit.names, RANKING.constant - 1)
    )


@pytest.mark.usefixtures("imitation")
def test_an_explanation_that_leaves_more_than_a_tenth_is_none() -> None:
    assert verdict_of(findings(fitted(1.0, COULOMB), [], [1.0], TRUTH)) == "explained"
    assert verdict_of(findings(fitted(3.0, COULOMB), [], [1.0], TRUTH)) == "unknown_effect"


@pytest.mark.usefixtures("imitation")
def test_with_an_exact_model_an_explanation_leaves_no_more_than_model_form_errors() -> None:
    wrong = replace(fitted(50.0, COULOMB), theta=np.array(encoded(candidates_of()[COULOMB], level=0.04)))
    found = findings(wrong, [], [1.0], TRUTH, null=1000.0)
    assert 0.02 < max(found.explanations.remainder, held_out_remainder(found)) < 0.1
    assert verdict_of(found) == "unknown_effect"


def test_an_explanation_that_does_not_hold_on_other_data_is_none() -> None:
    """Parameters that fit one log only: here they are wrong, as the fit is made by hand."""
    wrong = replace(fitted(1.0, COULOMB), theta=np.array(encoded(candidates_of()[COULOMB], level=0.1)))
    found = findings(wrong, [], [1.0], TRUTH)
    assert found.explanations.remainder == 0.0
    assert held_out_remainder(found) > 0.1
    assert verdict_of(found) == "unknown_effect"
    worse = findings(wrong, [], [1.0])  # the held-out log has no gap but with what was found in the other
    assert not held_out_gap(worse)
    assert held_out_remainder(worse) > 1.0


def test_an_explanation_that_predicts_other_data_worse_than_the_nominal_model_is_none() -> None:
    found = findings(fitted(1.0, COULOMB), [], [1.0], TRUTH)
    assert verdict_of(found) == "explained"
    assert verdict_of(found, worse=True) == "unknown_effect"


def test_another_fit_of_the_same_effects_is_no_rival() -> None:
    """It may have another initial value or range; there is nothing to tell apart."""
    found = findings(fitted(1.0, COULOMB), [fitted(1.0, COULOMB)], [0.6, 0.4], TRUTH)
    assert verdict_of(found) == "explained"
    assert best_rival(found.explanations) is None  # nor is the nominal model


@pytest.mark.parametrize(("probabilities", "verdict"), [([0.6, 0.4], "ambiguous"), ([0.9, 0.1], "explained")])
def test_rivals_within_a_factor_make_the_answer_ambiguous(probabilities: list[float], verdict: str) -> None:
    found = findings(fitted(1.0, COULOMB), [fitted(1.0, STIFFNESS)], probabilities, TRUTH)
    assert verdict_of(found) == verdict
    assert best_rival(found.explanations) is found.explanations.rivals[1]


def test_groups_are_the_effects_that_stand_for_one_another() -> None:
    chosen, rivals = fitted(1.0, COULOMB, STIFFNESS), [fitted(1.0, COULOMB, INERTIA), fitted(1.0, STIFFNESS)]
    found = findings(chosen, rivals, [0.5, 0.4, 0.1], TRUTH)
    assert groups_of(found.explanations) == ((effect_location(STIFFNESS), effect_location(INERTIA)),)


@pytest.mark.parametrize("swapped", [False, True])
def test_an_effect_that_a_rival_has_or_lacks_beside_all_others_is_a_group_alone(swapped: bool) -> None:
    pair = [fitted(1.0, COULOMB, STIFFNESS), fitted(1.0, COULOMB)]
    chosen, rival = reversed(pair) if swapped else pair
    found = findings(chosen, [rival], [0.5, 0.5], TRUTH)
    assert groups_of(found.explanations) == ((effect_location(STIFFNESS),),)


def test_the_probability_of_an_effect_is_that_of_all_its_explanations() -> None:
    found = findings(
        fitted(1.0, COULOMB), [fitted(1.0, COULOMB, STIFFNESS), fitted(1.0, INERTIA)], [0.5, 0.3, 0.2], TRUTH
    )
    assert probability_of(COULOMB, found, verdict_of(found)) == pytest.approx(0.8)
    assert probability_of(INERTIA, found, verdict_of(found)) == pytest.approx(0.2)
    assert probability_of("backlash@motor_1", found, verdict_of(found)) == 0.0


@pytest.mark.parametrize(("x", "verdict", "probability"), [
    (-0.67, "partly_explained", 0.1), (-0.67, "explained", 1.0), (0.02, "partly_explained", 1.0),
])  # fmt: skip
def test_an_effect_of_a_size_that_it_hardly_ever_has_is_improbable_beside_what_is_left(
    x: float, verdict: Verdict, probability: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A tether had been a tilt of 46 deg with certainty."""
    monkeypatch.setattr(decision, "placed_effects", lambda _: [parse_effect(f"base_tilt@base:x={x}", "test")])
    fit = SimpleNamespace(names={"base_tilt@base", COULOMB})
    explanations = SimpleNamespace(chosen=fit, rivals=(fit,), probabilities=(1.0,))
    found: Any = SimpleNamespace(explanations=explanations, settings=RANKING)
    assert probability_of("base_tilt@base", found, verdict) == pytest.approx(probability)
    assert probability_of(COULOMB, found, verdict) == pytest.approx(1.0)


def test_a_single_effect_of_constant_size_is_a_part_of_what_it_does_not_explain() -> None:
    """As a Coulomb friction beside pushes at the tool."""
    found = findings(fitted(3.0, COULOMB), [], [1.0], TRUTH)
    assert verdict_of(found) == "partly_explained"
    assert probability_of(COULOMB, found, verdict_of(found)) == pytest.approx(1.0)


@pytest.mark.parametrize("imported", [True, False])
def test_of_a_real_machine_what_closes_the_gap_ahead_is_a_part_though_single_samples_hardly_show_it(
    imported: bool,
) -> None:
    """As friction in a log of 48 Hz, whose torques are not those between its samples."""
    little = replace(fitted(9.0, COULOMB), theta=np.array(encoded(candidates_of()[COULOMB], level=0.003)))
    found = findings(little, [], [1.0], TRUTH)
    data, held = (replace(one, record=replace(one.record, imported=imported)) for one in (found.data, found.held))
    found = replace(found, data=data, held=held)
    assert held_out_remainder(found) > 1 - RANKING.confirmed_share
    assert verdict_of(found) == "unknown_effect"
    assert verdict_of(found, closed=0.1) == "unknown_effect"
    assert verdict_of(found, closed=0.9) == ("partly_explained" if imported else "unknown_effect")


@pytest.mark.usefixtures("imitation")
def test_an_effect_that_does_not_explain_the_gap_is_hardly_a_part_of_it() -> None:
    found = findings(fitted(3.0, COULOMB), [], [1.0], TRUTH)
    assert verdict_of(found) == "unknown_effect"
    assert probability_of(COULOMB, found, verdict_of(found)) == pytest.approx(0.1)


def test_of_equally_sure_effects_the_one_that_is_missed_most_comes_first() -> None:
    """Without the friction 4 are lost, without the stiffness 0.2, and the inertia is in the rival only."""
    chosen, friction, inertia = fitted(1.0, STIFFNESS, COULOMB), fitted(1.2, COULOMB), fitted(1.1, INERTIA)
    found = findings(chosen, [friction, fitted(5.0, STIFFNESS), inertia], [0.996, 0.003, 0.0, 0.001], TRUTH)
    ranked = sorted([STIFFNESS, INERTIA, COULOMB], key=lambda name: rank_key(name, found, verdict_of(found)))
    assert ranked == [COULOMB, STIFFNESS, INERTIA]


def test_rounding_stands_where_its_variance_puts_it() -> None:
    found = findings(fitted(1.0, COULOMB), [], [1.0], TRUTH, rounded=True)
    share = (1e-3) ** 2 / 12 / ROBOT.encoder_noise[0] ** 2
    assert rank_key("encoder_quantization@motor_1", found, verdict_of(found)) == (-1.0, pytest.approx(-share), -1.0)


def test_gain_in_the_held_out_log_is_of_its_own_errors() -> None:
    chosen = fitted(1.0, COULOMB)
    found = findings(chosen, [], [1.0], TRUTH)
    held = data_of(TRUTH, seed=2)
    squares = [
        float(np.sum(held.residuals(one.predictor, one.theta[:, None]) ** 2))
        for one in (found.explanations.null, chosen)
    ]
    assert held_out_gain(chosen, found) == pytest.approx(held.n_values * np.log(squares[0] / squares[1]))
    assert held_out_gain(chosen, found) > 1e4


def test_a_model_that_runs_away_in_the_held_out_log_gains_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    chosen = fitted(1.0, COULOMB)
    found = findings(chosen, [], [1.0], TRUTH)
    n = found.held.n_values
    monkeypatch.setattr(
        type(found.held), "residuals", lambda self, predictor, thetas: np.full((n, 1), np.nan if len(thetas) else 1.0)
    )
    assert held_out_gain(chosen, found) == -np.inf


def at_its_limit(name: str) -> CandidateFit:
    """Coulomb friction, and an effect whose size is the largest of its search."""
    pair = fitted(1.0, COULOMB, name)
    return replace(pair, theta=np.array([pair.theta[0], 1.0]))


def test_an_effect_at_the_limit_of_its_search_is_no_part_of_the_repair() -> None:
    found = findings(at_its_limit(INERTIA), [], [1.0], TRUTH)
    assert found.beyond_search == {INERTIA}
    assert [placed.effect.name for placed in repair_of(found)] == ["coulomb_friction"]
    assert found.repaired.theta[1] == 0.0


def test_a_torque_that_does_not_explain_the_motion_is_told() -> None:
    """Predictions are better the less of it acts: its gain ends at the limit of the search, and is no finding."""
    pair = fitted(1.0, COULOMB, GAIN)
    found = findings(replace(pair, theta=np.array([pair.theta[0], pair.predictor.bounds[0][1]])), [], [1.0], TRUTH)
    assert found.beyond_search == {GAIN}
    assert [placed.effect.name for placed in repair_of(found)] == ["coulomb_friction"]
    (text,) = _without_finding(found)
    assert "the torque of motor_1 in the log does not explain its motion" in text
    (other,) = _without_finding(findings(at_its_limit(GAIN), [], [1.0], TRUTH))
    assert "ended at the limit of its search" in other


def test_rounding_is_a_cause_though_no_other_effect_is_detected() -> None:
    found = findings(None, [], [], null=1.0, rounded=True)
    assert verdict_of(found) == "explained"
    (placed,) = repair_of(found)
    assert str(placed).startswith("encoder_quantization@motor_1:step=0.001")


def test_rounding_that_the_model_has_is_no_cause() -> None:
    known = place_effects(ROBOT, [parse_effect("encoder_quantization@motor_1:step=0.001", "test")])
    model = RobotWithEffects(known.robot, known.laws)
    found = findings(None, [], [], null=1.0, rounded=True, model=model)
    assert found.quantizations == ()
    assert verdict_of(found) == "no_gap"


def test_locations_are_split_from_names() -> None:
    split = effect_location("extra_mode@body_1.rz")
    assert (split.effect, split.location) == ("extra_mode", "body_1.rz")


def test_an_explanation_that_leaves_more_than_two_floors_is_one_in_part() -> None:
    """It is as good as its form allows, and confirmed, but something is left."""
    found = findings(fitted(1.0, COULOMB), [], [1.0], TRUTH)
    assert verdict_of(found, left=1.9) == "explained"
    assert verdict_of(found, left=2.1) == "partly_explained"


def test_on_a_real_machine_the_floor_contains_the_tolerance() -> None:
    found = findings(fitted(1.0, COULOMB), [], [1.0], TRUTH)
    real = replace(found, data=replace(found.data, record=replace(found.data.record, imported=True)))
    assert verdict_of(real, left=50.0) == "partly_explained"
    assert verdict_of(real, left=50.0, with_tolerance=26.0) == "explained"
    assert verdict_of(real, left=50.0, with_tolerance=24.0) == "partly_explained"
    far = replace(real, held_chosen=replace(real.held_chosen, chi2=2.1 * found.held.n_values))
    assert verdict_of(far, left=1.0) == "partly_explained"


def test_what_torques_within_the_assumed_tolerance_explain_is_no_remainder_of_better_ones() -> None:
    """With a delay and a ripple more an answer had been one in part, which was complete without them."""
    found = findings(fitted(1.0, COULOMB), [], [1.0], TRUTH)
    real = replace(found, data=replace(found.data, record=replace(found.data.record, imported=True)))
    far = replace(real, held_chosen=replace(real.held_chosen, chi2=2.1 * found.held.n_values))
    assert verdict_of(replace(far, torques_better=True), left=1.0) == "explained"
    assert verdict_of(replace(far, torques_better=True), left=2.1) == "partly_explained"


def test_torques_of_a_fit_on_a_real_machine_count_by_what_they_predict() -> None:
    """A fit weighs errors of torques by less than their tolerance, and the sum of both may be far above the floor."""
    good = fitted(50.0, COULOMB)
    off = replace(good, theta=good.theta + 1.0)
    found, far = (
        replace(one, data=replace(one.data, record=replace(one.data.record, imported=True)))
        for one in (findings(fit, [], [1.0], TRUTH, null=1e5) for fit in (good, off))
    )
    assert verdict_of(found, closed=1.0) == "explained"
    assert verdict_of(replace(far, held_chosen=found.held_chosen), closed=1.0) == "partly_explained"


def test_errors_of_a_real_machine_within_the_floors_of_an_explanation_are_no_gap() -> None:
    """Its floor holds the tolerance of torques as white torque, and real errors last."""
    found = findings(None, [], [], null=1.5)
    real = replace(found, data=replace(found.data, record=replace(found.data.record, imported=True)))
    assert verdict_of(found, left=1.9) == "unknown_effect"
    assert verdict_of(real, left=1.9) == "no_gap"
    assert verdict_of(real, left=2.1) == "unknown_effect"


def test_what_predicts_hardly_better_than_constant_speed_is_not_explained() -> None:
    found = findings(fitted(1.0, COULOMB), [], [1.0], TRUTH)
    assert verdict_of(found) == "explained"
    assert verdict_of(found, moving_on=True) == "partly_explained"
