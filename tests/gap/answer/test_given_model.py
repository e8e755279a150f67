"""The gap of the model as it was given: numbers that it lacks are a part of the repair."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.gap.answer.given_model import errors_over_rest
from flexros.gap.diagnose import diagnose
from flexros.gap.held_out.errors_ahead import AheadErrors
from flexros.gap.report.verdict import verdict_sentence
from flexros.gap.result import DiagnosisResult
from flexros.gap.settings import DiagnosisSettings, SearchSettings
from tests.gap.diagnosis_logs import data_of
from tests.gap.rigid_arm import arm, record_of_arm

pytestmark = pytest.mark.slow

FRICTION = ("coulomb_friction", "viscous_friction", "stribeck_friction")
SETTINGS = DiagnosisSettings(
    where=None, next_experiment=None, sensitivity=None, search=SearchSettings(effects=(*FRICTION, "payload_error"))
)


@pytest.fixture(scope="module")
def result() -> DiagnosisResult:
    """An arm with friction whose file gives no rotors; without its own the second joint flies off within 0.1 s."""
    fitted, held = (record_of_arm(imported=True, seed=seed, seconds=15.0) for seed in (5, 6))
    return diagnose(fitted, arm(), holdout=held, settings=SETTINGS)


def test_a_rotor_that_the_file_lacks_has_a_row_of_the_budget(result: DiagnosisResult) -> None:
    rows = {f"{one.effect}@{one.location}": one for one in result.diagnosis.budget if one.effect}
    row = rows["rotor_inertia@motor_1"]
    assert row.cause_class == "model numbers"
    assert row.share_first is not None
    assert row.share_first > 0.5
    assert {"coulomb_friction@motor_1", "coulomb_friction@motor_2"} <= set(rows)


def test_the_gap_before_is_that_without_this_rotor(result: DiagnosisResult) -> None:
    gap = result.diagnosis.gap
    assert gap.after is not None
    assert gap.before > 5 * gap.after  # an explanation with both rotors
    steps = sum(step.share for one in result.diagnosis.waterfall for step in one.steps)
    left = sum(one.left for one in result.diagnosis.waterfall)
    assert steps + left == pytest.approx(1.0)


def test_a_rotor_without_which_nothing_is_predicted_is_there_from_the_start(result: DiagnosisResult) -> None:
    (row,) = (one for one in result.diagnosis.budget if (one.effect, one.location) == ("rotor_inertia", "motor_2"))
    assert row.share_first is None
    assert row.share_last is not None
    assert row.share_last > 0.2
    steps = {(step.effect, step.location) for one in result.diagnosis.waterfall for step in one.steps}
    assert ("rotor_inertia", "motor_1") in steps
    assert ("rotor_inertia", "motor_2") not in steps
    (text,) = (text for text in result.diagnosis.warnings if "rotor_inertia" in text)
    assert "motor_2" in text
    assert "motor_1" not in text


def test_the_sentence_names_what_the_model_lacks(result: DiagnosisResult) -> None:
    sentence = verdict_sentence(result.diagnosis)
    assert "The model lacked" in sentence
    assert "rotor inertia at motor_1" in sentence


def test_a_load_that_the_file_lacks_has_a_row_of_the_budget() -> None:
    fitted, held = (record_of_arm(imported=True, seed=seed, load=7.0, seconds=10.0) for seed in (5, 6))
    few = SETTINGS.model_copy(update={"search": SearchSettings(effects=FRICTION[:2])})
    found = diagnose(fitted, arm(), holdout=held, settings=few).diagnosis
    (row,) = (one for one in found.budget if one.effect == "tool_load")
    assert (row.joint, row.cause_class) == ("tool", "model numbers")
    assert row.share_first is not None
    assert row.share_first > 0.5
    mass = next(one for one in found.model_numbers if one.name == "tool_load.mass")
    assert mass.determined


def test_errors_are_compared_with_those_of_a_motor_that_stays_where_it_is() -> None:
    held = data_of()
    horizon = round(0.1 / held.record.sample_time)
    starts = np.arange(0, held.record.n_samples - horizon, 40)
    moved = held.record.position[starts + horizon] - held.record.position[starts]
    errors = AheadErrors((2.0 * moved) ** 2, starts, np.ones(1))
    np.testing.assert_allclose(errors_over_rest(errors, held), [2.0])
