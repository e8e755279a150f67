"""Findings: verdict, rivals, groups and gap numbers from what was fitted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.effects import RobotWithEffects, parse_effect, place_effects
from flexros.gap.answer.decision import Findings, place_of
from flexros.gap.fit.least_squares import CandidateFit
from flexros.gap.search.forward_selection import Explanations
from flexros.gap.search.model_probability import evidence_of
from flexros.record.quantization import Quantization
from tests.gap.diagnosis_logs import MODEL, ROBOT, candidates_of, data_of, numbers, predictor_of

TRUTH = "coulomb_friction@motor_1:level=0.05"
COULOMB, STIFFNESS, INERTIA = (
    "coulomb_friction@motor_1", "stiffness_error@body_2.rz", "motor_inertia_error@motor_1",
)  # fmt: skip
VALUES = {COULOMB: {"level": 0.05}, STIFFNESS: {"relative": 0.03}, INERTIA: {"relative": 0.02}}


def fitted(level: float, *names: str) -> CandidateFit:
    """A fit that leaves a mean squared weighted error in the fitted log."""
    hypothesis = [candidates_of()[name] for name in names]
    theta = [number for one in hypothesis for number in numbers(one, **VALUES[one.name])]
    return CandidateFit(predictor_of(*hypothesis), np.array(theta), level * data_of(TRUTH).n_values)


def findings(
    chosen: CandidateFit | None,
    rivals: list[CandidateFit],
    probabilities: list[float],
    *effects: str,
    nothing: float = 10.0,
) -> Findings:
    """Findings with explanations made by hand, on logs with effects; `chosen` None for nothing."""
    data, held = (data_of(*effects, seed=seed) for seed in (1, 2))
    plain = fitted(nothing)
    among = ([] if chosen is None else [chosen]) + rivals + [plain]
    evidence = evidence_of(data, plain, among[:-1])
    found = Explanations(
        evidence, chosen or plain, tuple(among), np.array([*probabilities, 0.0]), detected=chosen is not None
    )
    return Findings(MODEL, data, held, found)


def quantized(found: Findings) -> Findings:
    measurement = replace(found.data.measurement, quantizations=(Quantization(0, 1e-3),))
    return replace(found, data=replace(found.data, measurement=measurement))


def test_nothing_left_is_no_gap_and_something_left_an_unknown_effect() -> None:
    assert findings(None, [], [], nothing=1.0).verdict == "no_gap"
    assert findings(None, [], [], nothing=2.0).verdict == "unknown_effect"


def test_an_explanation_that_leaves_more_than_a_tenth_is_none() -> None:
    assert findings(fitted(1.0, COULOMB), [], [1.0], TRUTH).verdict == "explained"
    assert findings(fitted(3.0, COULOMB), [], [1.0], TRUTH).verdict == "unknown_effect"


def test_beside_an_exact_model_an_explanation_leaves_no_more_than_errors_of_form() -> None:
    wrong = replace(fitted(50.0, COULOMB), theta=np.array(numbers(candidates_of()[COULOMB], level=0.04)))
    found = findings(wrong, [], [1.0], TRUTH, nothing=1000.0)
    assert 0.02 < max(found.explanations.left, found.held_out_left) < 0.1
    assert found.verdict == "unknown_effect"


def test_an_explanation_that_does_not_hold_on_other_data_is_none() -> None:
    """Numbers that fit one log only: here they are wrong, as the fit is made by hand."""
    wrong = replace(fitted(1.0, COULOMB), theta=np.array(numbers(candidates_of()[COULOMB], level=0.1)))
    found = findings(wrong, [], [1.0], TRUTH)
    assert found.explanations.left == 0.0
    assert found.held_out_left > 0.1
    assert found.verdict == "unknown_effect"
    worse = findings(wrong, [], [1.0])  # the held-out log has no gap but with what was found in the other
    assert not worse.held_out_gap
    assert worse.held_out_left > 1.0


@pytest.mark.parametrize(("probabilities", "verdict"), [([0.6, 0.4], "ambiguous"), ([0.9, 0.1], "explained")])
def test_rivals_within_a_factor_make_the_answer_ambiguous(probabilities: list[float], verdict: str) -> None:
    found = findings(fitted(1.0, COULOMB), [fitted(1.0, STIFFNESS)], probabilities, TRUTH)
    assert found.verdict == verdict
    assert found.best_rival is found.explanations.rivals[1]


def test_groups_are_the_effects_that_stand_for_one_another() -> None:
    chosen, rivals = fitted(1.0, COULOMB, STIFFNESS), [fitted(1.0, COULOMB, INERTIA), fitted(1.0, STIFFNESS)]
    found = findings(chosen, rivals, [0.5, 0.4, 0.1], TRUTH)
    assert found.groups() == ((place_of(STIFFNESS), place_of(INERTIA)),)


def test_the_probability_of_an_effect_is_that_of_all_its_explanations() -> None:
    found = findings(
        fitted(1.0, COULOMB), [fitted(1.0, COULOMB, STIFFNESS), fitted(1.0, INERTIA)], [0.5, 0.3, 0.2], TRUTH
    )
    assert found.probability(COULOMB) == pytest.approx(0.8)
    assert found.probability(INERTIA) == pytest.approx(0.2)
    assert found.probability("backlash@motor_1") == 0.0


def test_an_effect_that_does_not_explain_the_gap_is_hardly_a_part_of_it() -> None:
    found = findings(fitted(3.0, COULOMB), [], [1.0], TRUTH)
    assert found.verdict == "unknown_effect"
    assert found.probability(COULOMB) == pytest.approx(0.1)


def test_of_equally_sure_effects_the_one_that_is_missed_most_comes_first() -> None:
    """Without the friction 4 are lost, without the stiffness 0.2, and the inertia is in the rival only."""
    chosen, friction, inertia = fitted(1.0, STIFFNESS, COULOMB), fitted(1.2, COULOMB), fitted(1.1, INERTIA)
    found = findings(chosen, [friction, fitted(5.0, STIFFNESS), inertia], [0.996, 0.003, 0.0, 0.001], TRUTH)
    assert sorted([STIFFNESS, INERTIA, COULOMB], key=found.order) == [COULOMB, STIFFNESS, INERTIA]


def test_rounding_stands_where_its_variance_puts_it() -> None:
    found = quantized(findings(fitted(1.0, COULOMB), [], [1.0], TRUTH))
    share = (1e-3) ** 2 / 12 / ROBOT.encoder_noise[0] ** 2
    assert found.order("encoder_quantization@motor_1") == (-1.0, pytest.approx(-share), -1.0)


def test_gap_numbers_are_of_the_held_out_log() -> None:
    found = findings(fitted(1.0, COULOMB), [fitted(9.0, INERTIA)], [1.0, 0.0], TRUTH)
    gap = found.gap
    assert gap.before == pytest.approx(found.errors(found.explanations.evidence.nothing).mean)
    assert gap.before > 20
    assert gap.after == pytest.approx(1.0, abs=0.4)
    assert gap.best_rival is not None
    assert gap.best_rival > 10
    assert gap.closed_fraction == pytest.approx(1.0, abs=0.05)
    (signal,) = found.signals
    assert signal.after is not None
    assert signal.after < 0.3 * signal.before


def test_gain_in_the_held_out_log_is_of_its_own_errors() -> None:
    chosen = fitted(1.0, COULOMB)
    found = findings(chosen, [], [1.0], TRUTH)
    held = data_of(TRUTH, seed=2)
    squares = [
        float(np.sum(held.residuals(one.predictor, one.theta[:, None]) ** 2))
        for one in (found.explanations.evidence.nothing, chosen)
    ]
    assert found.held_gain(chosen) == pytest.approx(held.n_values * np.log(squares[0] / squares[1]))
    assert found.held_gain(chosen) > 1e4


def test_a_model_that_runs_away_in_the_held_out_log_gains_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    chosen = fitted(1.0, COULOMB)
    found = findings(chosen, [], [1.0], TRUTH)
    n = found.held.n_values
    monkeypatch.setattr(
        type(found.held), "residuals", lambda self, predictor, thetas: np.full((n, 1), np.nan if len(thetas) else 1.0)
    )
    assert found.held_gain(chosen) == -np.inf


def test_without_gap_there_is_nothing_to_close() -> None:
    gap = findings(None, [], [], nothing=1.0).gap
    assert (gap.after, gap.closed_fraction, gap.best_rival) == (None, None, None)
    assert gap.before == pytest.approx(1.0, abs=0.4)


def test_rounding_is_a_cause_though_no_other_effect_is_detected() -> None:
    found = quantized(findings(None, [], [], nothing=1.0))
    assert found.verdict == "explained"
    (placed,) = found.patch
    assert str(placed).startswith("encoder_quantization@motor_1:step=0.001")


def test_rounding_that_the_model_has_is_no_cause() -> None:
    known = place_effects(ROBOT, [parse_effect("encoder_quantization@motor_1:step=0.001", "test")])
    found = replace(quantized(findings(None, [], [], nothing=1.0)), model=RobotWithEffects(known.robot, known.laws))
    assert found.quantized == ()
    assert found.verdict == "no_gap"


def test_places_are_split_from_names() -> None:
    place = place_of("extra_mode@body_1.rz")
    assert (place.effect, place.location) == ("extra_mode", "body_1.rz")
