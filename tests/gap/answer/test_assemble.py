"""The answer: causes, ranking and warnings of what was found."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.gap.answer import assemble
from flexros.gap.answer import assemble as answer
from flexros.gap.answer.assemble import result_of
from flexros.gap.answer.decision import findings_of
from flexros.gap.deadline import Deadline
from flexros.gap.fit.candidate_fit import CandidateFit
from flexros.gap.held_out.errors_ahead import errors_ahead
from flexros.gap.held_out.predictions import prediction_of
from flexros.gap.progress import Stages
from flexros.gap.residuals.fit_data import FitData
from flexros.gap.result import DiagnosisResult
from flexros.gap.search.forward_selection import Explanations
from flexros.gap.search.model_probability import ModelComparison
from flexros.gap.settings import DiagnosisSettings, RankingSettings
from flexros.record.quantization import Quantization
from tests.gap.diagnosis_logs import MODEL, candidates_of, data_of, encoded, predictor_of

pytestmark = pytest.mark.slow

TRUTH = "coulomb_friction@motor_1:level=0.05"
COULOMB, STIFFNESS = "coulomb_friction@motor_1", "stiffness_error@body_2.rz"
TOLERANCE = {"stiffness": 0.01}
SETTINGS = DiagnosisSettings(level=1e-3, next_experiment=None)
SMALL = "motor_inertia_error@motor_1", "damping_error@body_2.rz"
VALUES = {COULOMB: {"level": 0.05}, STIFFNESS: {"relative": 0.03}, **{name: {"relative": 1e-4} for name in SMALL}}


def fitted(level: float, *names: str) -> CandidateFit:
    hypothesis = [candidates_of()[name] for name in names]
    theta = np.array([value for one in hypothesis for value in encoded(one, **VALUES[one.name])])
    return CandidateFit(predictor_of(*hypothesis), theta, level * data_of(TRUTH).n_values, 1e4 * np.eye(len(theta)))


def answered(
    chosen: CandidateFit,
    *rivals: CandidateFit,
    probabilities: tuple[float, ...],
    rounded: bool = False,
    data: FitData | None = None,
    settings: DiagnosisSettings = SETTINGS,
    detected: bool = True,
    elsewhere: tuple[CandidateFit, ...] = (),
    by_probability: bool = False,
) -> DiagnosisResult:
    """The answer to a log with friction."""
    data, held = data or data_of(TRUTH), data_of(TRUTH, seed=2)
    if rounded:
        data = replace(data, measurement=replace(data.measurement, quantizations=(Quantization(0, 1e-3),)))
    null = chosen if not detected else fitted(50.0)
    fits = (chosen, *rivals) if detected else ()
    comparison = ModelComparison(null, fits, data.n_values)
    order = np.argsort([-one for one in probabilities], kind="stable") if by_probability else range(len(fits))
    rivals = (*(fits[k] for k in order), null)
    explanations = Explanations(
        comparison, chosen, rivals, np.array([*(probabilities[k] for k in order), 0.0]), detected
    )
    found = findings_of(
        MODEL, data, held, explanations, tolerance=TOLERANCE, settings=settings.ranking, elsewhere=elsewhere
    )
    return result_of(found, prediction_of(null, data), None, settings, Stages(None), Deadline())


@pytest.fixture(scope="module")
def result() -> DiagnosisResult:
    return answered(fitted(1.0, COULOMB), fitted(20.0, STIFFNESS), probabilities=(0.95, 0.05))


def test_causes_are_those_of_the_chosen_explanation(result: DiagnosisResult) -> None:
    (cause,) = result.diagnosis.causes
    assert (cause.effect, cause.location, cause.probability) == ("coulomb_friction", "motor_1", 0.95)
    assert cause.parameters["level"].value == pytest.approx(0.05)
    assert 0.0 < cause.parameters["level"].std < 0.01 * 0.05
    assert cause.closed_fraction == pytest.approx(1.0, abs=0.05)


def test_all_that_was_tried_is_ranked_with_what_it_leaves(result: DiagnosisResult) -> None:
    assert [one.effect for one in result.ranking] == ["coulomb_friction", "stiffness_error"]
    assert [one.remainder for one in result.ranking] == [0.0, pytest.approx(19 / 49)]
    assert result.ranking[0].gain > result.ranking[1].gain
    assert result.null_probability == 0.0


def test_effects_of_the_chosen_explanation_have_its_sizes_in_the_ranking_too() -> None:
    """A rival may be more probable, as the mean over tolerances is; the patch holds the chosen one."""
    chosen, rival = fitted(1.0, COULOMB, SMALL[0]), fitted(1.0, COULOMB, SMALL[1])
    ranking = answered(chosen, rival, probabilities=(0.4, 0.6), by_probability=True).ranking
    friction = next(one for one in ranking if one.effect == "coulomb_friction")
    assert [one.effect for one in friction.together_with] == ["motor_inertia_error"]


def test_the_first_of_the_ranking_have_their_gain_in_the_held_out_log(result: DiagnosisResult) -> None:
    right, wrong = (one.holdout_gain for one in result.ranking)
    assert right is not None
    assert wrong is not None
    assert right > 1e4
    assert wrong < 0.1 * right
    settings = DiagnosisSettings(ranking=RankingSettings(confirmed=1))
    fits = fitted(1.0, COULOMB), fitted(20.0, STIFFNESS)
    ranking = answered(*fits, probabilities=(0.95, 0.05), settings=settings).ranking
    assert [one.holdout_gain for one in ranking] == [right, None]


def test_before_after_and_rival_are_separate_models(result: DiagnosisResult) -> None:
    assert result.before.effects == ()
    assert result.after is not None
    assert result.rival is not None
    assert result.after.name == COULOMB
    assert result.rival.name == STIFFNESS
    assert result.after.effects == result.patch


def test_provenance_names_log_robot_and_settings(result: DiagnosisResult) -> None:
    provenance = result.diagnosis.provenance
    assert (provenance["log"], provenance["robot"], provenance["level"]) == ("log", "four_mass_linear", 1e-3)
    assert provenance["stiffness"] == TOLERANCE["stiffness"]
    assert provenance["ranking"]["unexplained"] == 0.1
    assert provenance["search"]["most_effects"] == 30


def test_rivals_of_an_ambiguous_answer_are_causes_too() -> None:
    found = answered(fitted(1.0, COULOMB), fitted(1.0, STIFFNESS), probabilities=(0.55, 0.45)).diagnosis
    assert found.verdict == "ambiguous"
    assert [(one.effect, one.probability) for one in found.causes] == [
        ("coulomb_friction", 0.55), ("stiffness_error", 0.45),
    ]  # fmt: skip
    assert len(found.ambiguity_groups) == 1


def test_names_that_hang_on_tolerances_are_groups_of_an_explanation_in_part_too() -> None:
    chosen, other = (fitted(12.0, COULOMB, name) for name in SMALL)
    found = answered(chosen, other, probabilities=(0.9, 0.1), elsewhere=(other,)).diagnosis
    assert found.verdict == "partly_explained"
    ((first, second),) = found.ambiguity_groups
    assert (first.effect, second.effect) == ("motor_inertia_error", "damping_error")


def test_next_experiment_is_chosen_with_the_tolerance_of_the_diagnosis(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[object] = []
    monkeypatch.setattr(answer, "next_experiment", lambda *_, tolerance, **__: asked.append(tolerance))
    answered(fitted(1.0, COULOMB), fitted(1.0, STIFFNESS), probabilities=(0.55, 0.45), settings=DiagnosisSettings())
    assert asked == [TOLERANCE]


def test_of_equally_sure_causes_the_one_that_is_missed_most_is_first() -> None:
    both = fitted(1.0, STIFFNESS, COULOMB)
    singles = fitted(40.0, STIFFNESS), fitted(1.0, COULOMB)
    causes = answered(both, *singles, probabilities=(1.0, 0.0, 0.0)).diagnosis.causes
    assert [one.effect for one in causes] == ["coulomb_friction", "stiffness_error"]


def test_an_effect_at_the_limit_of_its_search_is_flagged_and_otherwise_left_out() -> None:
    pair = fitted(1.0, COULOMB, STIFFNESS)
    limited = replace(pair, theta=np.array([pair.theta[0], 1.0]))
    result = answered(limited, fitted(1.5, COULOMB), probabilities=(1.0, 0.0))
    diagnosis = result.diagnosis
    flags = {one.effect: [size.at_limit for size in one.parameters.values()] for one in diagnosis.causes}
    assert flags == {"coulomb_friction": [False], "stiffness_error": [True]}
    assert [one.effect for one in diagnosis.budget] == ["coulomb_friction"]
    assert {step.effect for one in diagnosis.waterfall for step in one.steps} == {"coulomb_friction"}
    assert diagnosis.model_numbers == ()
    assert [placed.effect.name for placed in result.patch] == ["coulomb_friction"]
    assert diagnosis.gap.after == pytest.approx(1.0, abs=0.4)  # without the effect, as the patch is
    assert any(STIFFNESS in text for text in diagnosis.warnings)


def test_a_size_that_the_log_does_not_determine_is_flagged() -> None:
    pair = fitted(1.0, COULOMB, STIFFNESS)
    data = data_of(TRUTH)
    small = replace(pair, theta=np.array([pair.theta[0], encoded(candidates_of()[STIFFNESS], relative=1e-7)[0]]))
    diagnosis = answered(small, fitted(1.5, COULOMB), probabilities=(1.0, 0.0), data=data).diagnosis
    assert {one.effect: one.determined for one in diagnosis.causes} == {
        "coulomb_friction": True, "stiffness_error": False,
    }  # fmt: skip
    assert [one.determined for one in diagnosis.model_numbers] == [False]


def test_rounding_is_a_certain_cause_in_addition_to_others() -> None:
    found = answered(fitted(1.0, COULOMB), probabilities=(0.9,), rounded=True).diagnosis
    friction, rounding = found.causes
    assert (friction.effect, rounding.effect) == ("coulomb_friction", "encoder_quantization")
    assert rounding.probability == 1.0
    assert (rounding.parameters["step"].value, rounding.parameters["step"].unit) == (1e-3, "rad")
    assert rounding.closed_fraction == pytest.approx(0.0, abs=0.01)  # the log has no such rounding
    assert friction.closed_fraction == pytest.approx(1.0, abs=0.05)


def test_causes_and_ranking_have_the_order_of_what_is_closed() -> None:
    """The friction closes the gap, and is less probable than the stiffness, which closes nothing."""
    result = answered(fitted(1.0, COULOMB, STIFFNESS), fitted(1.2, STIFFNESS), probabilities=(0.6, 0.4))
    causes = [one.effect for one in result.diagnosis.causes]
    assert causes == [one.effect for one in result.ranking] == ["coulomb_friction", "stiffness_error"]


def test_what_an_explanation_leaves_is_warned_of() -> None:
    found = answered(fitted(3.0, COULOMB), probabilities=(1.0,)).diagnosis
    assert any("leaves 4.1 % of the gap" in text for text in found.warnings)


def test_what_was_noticed_of_the_tool_tracker_is_warned_of() -> None:
    seen = data_of(TRUTH, tool=True)
    assert seen.tool is not None
    seen = replace(seen, tool=replace(seen.tool, warnings=("late",)))
    found = answered(fitted(1.0, COULOMB), probabilities=(1.0,), data=seen).diagnosis
    assert "late" in found.warnings


def test_an_explanation_that_does_not_hold_elsewhere_is_warned_of() -> None:
    found = answered(fitted(1.0, STIFFNESS), probabilities=(1.0,)).diagnosis
    assert any("worse than the nominal model" in text for text in found.warnings)


def test_what_predicts_the_held_out_log_worse_is_no_patch() -> None:
    assert not answered(fitted(1.0, STIFFNESS), probabilities=(1.0,)).patch


def test_gap_numbers_are_of_the_held_out_log() -> None:
    result = answered(fitted(1.0, COULOMB), fitted(9.0, STIFFNESS), probabilities=(1.0, 0.0))
    gap = result.diagnosis.gap
    assert gap.before == pytest.approx(errors_ahead(fitted(50.0), data_of(TRUTH, seed=2)).mean)
    assert gap.before > 20
    assert gap.after == pytest.approx(1.0, abs=0.4)
    assert gap.best_rival is not None
    assert gap.best_rival > 10
    assert gap.closed_fraction == pytest.approx(1.0, abs=0.05)
    (signal,) = result.signals
    assert signal.after is not None
    assert signal.after < 0.3 * signal.before


def test_without_a_repair_there_is_nothing_after_it() -> None:
    result = answered(fitted(1.0), probabilities=(), detected=False, data=data_of())
    gap = result.diagnosis.gap
    assert (gap.after, gap.closed_fraction, gap.best_rival) == (None, None, None)
    assert result.patch == ()
    assert result.after is None


@pytest.mark.parametrize(("chosen", "settled"), [(COULOMB, True), (STIFFNESS, False)])
def test_a_repair_that_closes_the_gap_settles_doubts_about_the_nominal_model(chosen: str, settled: bool) -> None:
    data = data_of(TRUTH)
    doubted = replace(data.record, warnings=("about the log", "about the model"), doubts=("about the model",))
    result = answered(fitted(1.0, chosen), probabilities=(1.0,), data=replace(data, record=doubted))
    for warnings in (result.diagnosis.warnings, result.record.warnings):
        assert "about the log" in warnings
        assert ("about the model" in warnings) != settled


def test_without_a_gap_nothing_doubts_the_nominal_model(monkeypatch: pytest.MonkeyPatch) -> None:
    """A right model with its friction was told to explain little of a torque that was mostly friction."""
    monkeypatch.setattr(assemble, "verdict_of", lambda *_, **__: "no_gap")
    data = data_of()
    doubted = replace(data.record, warnings=("about the log", "about the model"), doubts=("about the model",))
    result = answered(fitted(1.0), probabilities=(), detected=False, data=replace(data, record=doubted))
    assert "about the log" in result.diagnosis.warnings
    assert "about the model" not in result.diagnosis.warnings


@pytest.mark.parametrize(("chosen", "settled"), [(COULOMB, True), (STIFFNESS, False)])
def test_an_explanation_settles_whether_the_torques_are_right(chosen: str, settled: bool) -> None:
    data = data_of(TRUTH)
    doubted = replace(data.record, warnings=("torques or model",), open_doubts=("torques or model",))
    result = answered(fitted(1.0, chosen), probabilities=(1.0,), data=replace(data, record=doubted))
    assert (result.diagnosis.verdict == "explained") == settled
    assert ("torques or model" in result.diagnosis.warnings) != settled


@pytest.mark.parametrize(("chosen", "told"), [(COULOMB, False), (STIFFNESS, True)])
def test_joints_that_the_mapping_does_not_turn_are_told_where_a_gap_is_left(chosen: str, told: bool) -> None:
    data = data_of(TRUTH)
    record = replace(data.record, not_turned=("lift (motor_1)",))
    result = answered(fitted(1.0, chosen), probabilities=(1.0,), data=replace(data, record=record))
    assert any("lift (motor_1)" in text for text in result.diagnosis.warnings) == told
