"""Names of an answer with halved and doubled tolerances of the nominal model."""

from __future__ import annotations

from dataclasses import replace

import pytest

from flexros.gap.answer.sensitivity import Sensitivity, sensitivity_of
from flexros.gap.deadline import Deadline
from flexros.gap.diagnose import diagnose
from flexros.gap.diagnosis_task import DiagnosisTask, SearchedLog
from flexros.gap.progress import Stages
from flexros.gap.residuals.fit_data import FitData
from flexros.gap.schema import Diagnosis
from flexros.gap.search.forward_selection import Explanations
from flexros.gap.settings import SensitivitySettings
from flexros.record.record import Record
from tests.gap.diagnosis_logs import MODEL, ROBOT, predictor_of, record_of, settings_of

pytestmark = pytest.mark.slow

SETTINGS = settings_of("coulomb_friction", "motor_inertia_error")
FRICTION, HEAVY = "coulomb_friction@motor_1:level=0.05", "motor_inertia_error@motor_1:relative=0.1"
LENGTH = 3.0
"""Of the logs [s]."""
STATED = 0.022
"""Tolerance of which the error of the inertia is 4.5 standard deviations [1]; twice of it allows for that error."""


def recorded(seed: int) -> Record:
    """A log that could be that of a machine."""
    return replace(record_of(FRICTION, HEAVY, length=LENGTH, seed=seed), simulated=False)


def diagnosed(tolerance: float, **others: float) -> Diagnosis:
    tolerances = {"inertia": tolerance, **others}
    return diagnose(recorded(1), ROBOT, holdout=recorded(2), tolerance=tolerances, settings=SETTINGS).diagnosis


@pytest.fixture(scope="module")
def task() -> DiagnosisTask:
    return DiagnosisTask(MODEL, recorded(2), {"inertia": STATED}, (), SETTINGS, Deadline(), Stages(None))


@pytest.fixture(scope="module")
def searched(task: DiagnosisTask) -> SearchedLog:
    return task.searched(recorded(1))


@pytest.fixture(scope="module")
def guessed(task: DiagnosisTask, searched: SearchedLog) -> Diagnosis:
    return task.answered(searched).diagnosis


def sensitivity(
    searched: SearchedLog,
    settings: SensitivitySettings | None = SETTINGS.sensitivity,
    explanations: Explanations | None = None,
    data: FitData | None = None,
) -> Sensitivity:
    """Compare the explanations of the search at other tolerances, or others, or those of another log."""
    explanations, data = explanations or searched.explanations, data or searched.null.data
    return sensitivity_of(explanations, data, MODEL, searched.unknown, settings, lambda: False)


def test_a_name_that_changes_with_the_tolerance_is_ambiguous(guessed: Diagnosis) -> None:
    rows = {row.effect: row for row in guessed.tolerance_sensitivity}
    assert rows["motor_inertia_error"].changes
    assert rows["motor_inertia_error"].stated > 0.9 > 0.5 > rows["motor_inertia_error"].doubled
    assert guessed.verdict == "ambiguous"


def test_a_name_that_does_not_change_is_sure(guessed: Diagnosis) -> None:
    row = next(row for row in guessed.tolerance_sensitivity if row.effect == "coulomb_friction")
    assert not row.changes
    assert min(row.halved, row.stated, row.doubled) > 0.99


def test_probabilities_are_the_mean_over_the_tolerances(guessed: Diagnosis) -> None:
    row = next(row for row in guessed.tolerance_sensitivity if row.changes)
    cause = next(cause for cause in guessed.causes if cause.effect == row.effect)
    assert cause.probability == pytest.approx((row.halved + row.stated + row.doubled) / 3, abs=1e-6)


def test_linear_theory_agrees_with_a_diagnosis_at_the_other_tolerance(guessed: Diagnosis) -> None:
    named = {cause.effect for cause in diagnosed(2 * STATED).causes if cause.probability > 0.5}
    assert named == {row.effect for row in guessed.tolerance_sensitivity if row.doubled > 0.5}


def test_many_tolerated_parameters_agree_with_a_diagnosis_too() -> None:
    """They are fitted along the directions in which the log informs."""
    rows = diagnosed(0.008, stiffness=1e-4, damping=1e-3).tolerance_sensitivity
    other = diagnosed(0.016, stiffness=2e-4, damping=2e-3)
    assert {row.effect for row in rows} == {"coulomb_friction", "motor_inertia_error"}
    named = {cause.effect for cause in other.causes if cause.probability > 0.5}
    assert named == {row.effect for row in rows if row.doubled > 0.5}


def test_a_small_tolerance_changes_no_name() -> None:
    diagnosis = diagnosed(0.004)
    assert not any(row.changes for row in diagnosis.tolerance_sensitivity)
    assert {row.effect for row in diagnosis.tolerance_sensitivity} == {"coulomb_friction", "motor_inertia_error"}
    assert diagnosis.verdict != "ambiguous"


def test_exact_models_and_simulated_logs_have_no_guesses(searched: SearchedLog) -> None:
    explanations, data = searched.explanations, searched.null.data
    null = replace(explanations.null, predictor=predictor_of())
    exact = replace(explanations, comparison=replace(explanations.comparison, null=null))
    assert sensitivity(searched, explanations=exact).rows == ()
    assert sensitivity(searched, data=replace(data, record=replace(data.record, simulated=True))).rows == ()


def test_it_can_be_left_out(task: DiagnosisTask, searched: SearchedLog) -> None:
    without = replace(task, settings=SETTINGS.model_copy(update={"sensitivity": None}))
    assert without.answered(searched).diagnosis.tolerance_sensitivity == ()


def test_no_explanation_is_fitted_again_where_none_is_asked_for(
    searched: SearchedLog, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("flexros.gap.answer.sensitivity.fit_again", lambda *_, **__: pytest.fail("it was fitted again"))
    assert sensitivity(searched, SensitivitySettings(refitted=0)).rows
