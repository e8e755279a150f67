"""The gap of a log without a diagnosis."""

from __future__ import annotations

from dataclasses import replace
from itertools import groupby

import pytest

from flexros.effects import RobotWithEffects, parse_effect, place_effects
from flexros.errors import InputError
from flexros.gap import measure_gap as module
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.deadline import Deadline
from flexros.gap.fit.null_fit import fit_null
from flexros.gap.fit.torques.unknown_numbers import UnknownNumbers
from flexros.gap.measure_gap import measure_gap
from flexros.gap.residuals.fit_data import FitData
from flexros.gap.residuals.prepare_fit_data import fit_data
from flexros.gap.search.model_probability import compare
from flexros.gap.settings import DiagnosisSettings
from flexros.record.record import Record
from flexros.robot.robot import Robot
from tests.gap.diagnosis_logs import MODEL, ROBOT, record_of
from tests.gap.rigid_arm import arm, record_of_arm

pytestmark = pytest.mark.slow

FRICTION = "coulomb_friction@motor_1:level=0.05"


def test_without_gap_it_is_one_and_not_significant() -> None:
    found = measure_gap(record_of(), MODEL)
    assert found.numbers.before == pytest.approx(1.0, abs=0.3)
    assert found.numbers.after is None
    assert not found.significant


def test_noise_that_is_a_little_more_than_declared_is_no_gap_here_as_it_is_none_in_a_diagnosis() -> None:
    sensors = ROBOT.spec.sensors
    noise = sensors.encoder_noise.model_copy(update={"value": sensors.encoder_noise.value / 1.04})
    spec = ROBOT.spec.model_copy(update={"sensors": sensors.model_copy(update={"encoder_noise": noise})})
    quieter = RobotWithEffects(Robot(spec, ROBOT.source), ())
    record = record_of()
    data = fit_data(record, quieter, DiagnosisSettings())
    null = fit_null(data, quieter, Tolerance()).fit
    assert compare(data, null).significant(null)
    assert not measure_gap(record, quieter).significant


def test_numbers_that_a_wide_tolerance_moves_far_are_stated() -> None:
    """An inertia was found within its tolerance of 30 %, and a patch that stated it closed 0 % without a word."""
    tolerance = {"stiffness": 0.0, "damping": 0.0, "inertia": 0.3}
    found = measure_gap(record_of("motor_inertia_error@motor_1:relative=1.5"), MODEL, tolerance=tolerance)
    (text,) = (text for text in found.warnings if "moved beyond their tolerance" in text)
    assert text.startswith("the nominal model is that with")
    assert "motor_1.inertia to 2." in text
    assert not any("moved beyond" in text for text in measure_gap(record_of(), MODEL, tolerance=tolerance).warnings)


@pytest.mark.parametrize(("patch", "said"), [("motor_inertia_error@motor_1:relative=1.5", True), (FRICTION, False)])
def test_that_a_patch_closes_little_is_said_where_it_does(patch: str, said: bool) -> None:
    hidden = ("motor_inertia_error@motor_1:relative=1.5", *([] if said else [FRICTION]))
    tolerance = {"stiffness": 0.0, "damping": 0.0, "inertia": 0.3}
    repaired = place_effects(ROBOT, [parse_effect(patch, "test")])
    found = measure_gap(record_of(*hidden), MODEL, repaired=repaired, tolerance=tolerance)
    (text,) = (text for text in found.warnings if "moved beyond their tolerance" in text)
    assert text.startswith("before the patch the nominal model is that with")
    assert ("closes little" in text) == said


def test_a_hidden_effect_is_significant() -> None:
    found = measure_gap(record_of(FRICTION), MODEL)
    assert found.numbers.before > 20
    assert found.significant


def test_a_repaired_model_closes_it() -> None:
    repaired = place_effects(ROBOT, [parse_effect(FRICTION, "test")])
    found = measure_gap(record_of(FRICTION), MODEL, repaired=repaired)
    assert found.numbers.closed_fraction == pytest.approx(1.0, abs=0.02)
    assert found.numbers.after == pytest.approx(1.0, abs=0.3)
    assert not found.significant


def test_a_wrong_repair_stays_significant() -> None:
    wrong = place_effects(ROBOT, [parse_effect("coulomb_friction@motor_1:level=0.03", "test")])
    found = measure_gap(record_of(FRICTION), MODEL, repaired=wrong)
    assert found.numbers.closed_fraction is not None
    assert 0.5 < found.numbers.closed_fraction < 0.99
    assert found.significant


def test_rounding_of_an_encoder_is_a_gap_until_the_model_has_it() -> None:
    rounding = "encoder_quantization@motor_1:step=0.002"
    repaired = place_effects(ROBOT, [parse_effect(rounding, "test")])
    record = record_of(rounding)
    before, after = measure_gap(record, MODEL), measure_gap(record, MODEL, repaired=repaired)
    assert before.significant
    assert before.numbers.before > 10
    assert not after.significant
    assert after.numbers.before == before.numbers.before
    assert after.numbers.after == pytest.approx(1.0, abs=0.3)
    assert after.numbers.closed_fraction == pytest.approx(1.0, abs=0.03)


def test_what_the_tolerance_allows_is_no_gap() -> None:
    record = record_of("stiffness_error@body_2.rz:relative=-0.05")
    assert measure_gap(record, MODEL).significant
    tolerated = measure_gap(record, MODEL, tolerance={"stiffness": 0.05})
    assert not tolerated.significant
    assert tolerated.numbers.before == pytest.approx(1.0, abs=0.3)


def test_the_floor_with_tolerance_is_stated_for_logs_of_real_machines() -> None:
    assert measure_gap(record_of(), MODEL).numbers.tolerance_floor is None
    floor = measure_gap(record_of_arm(imported=True), RobotWithEffects(arm(), ())).numbers.tolerance_floor
    assert floor is not None
    assert floor > 1.1


def test_progress_tells_which_model_predicts() -> None:
    calls: list[tuple[str, float]] = []
    repaired = place_effects(ROBOT, [parse_effect(FRICTION, "test")])
    measure_gap(record_of(), MODEL, repaired=repaired, progress=lambda *call: calls.append(call))
    assert calls == [("nominal model", 0.0), ("repaired model", 0.5)]


def test_a_repaired_model_that_closes_the_gap_settles_doubts_about_the_nominal_one() -> None:
    record = replace(record_of(FRICTION), warnings=("about the log", "about the model"), doubts=("about the model",))
    repaired = place_effects(ROBOT, [parse_effect(FRICTION, "test")])
    assert measure_gap(record, MODEL).warnings[:2] == ("about the log", "about the model")
    assert "about the model" not in measure_gap(record, MODEL, repaired=repaired).warnings


def test_without_a_gap_nothing_doubts_the_nominal_model() -> None:
    doubted = replace(record_of(), warnings=("about the model",), doubts=("about the model",))
    assert measure_gap(doubted, MODEL).warnings == ()


@pytest.mark.parametrize(("hidden", "told"), [((FRICTION,), True), ((), False)])
def test_joints_that_the_mapping_does_not_turn_are_told_beside_a_gap(hidden: tuple[str, ...], told: bool) -> None:
    record = replace(record_of(*hidden), not_turned=("lift (motor_1)",))
    assert any("lift (motor_1)" in text for text in measure_gap(record, MODEL).warnings) == told


GAIN = "torque_gain_error@motor_1:relative=-0.3"


@pytest.mark.parametrize(("patch", "kept"), [([FRICTION], False), ([FRICTION, GAIN], True), ([GAIN], True)])
def test_what_explains_the_log_settles_whether_the_torques_are_right(patch: list[str], kept: bool) -> None:
    hidden = patch if FRICTION in patch else [FRICTION]
    record = replace(record_of(*hidden), warnings=("torques or model",), open_doubts=("torques or model",))
    repaired = place_effects(ROBOT, [parse_effect(text, "test") for text in patch])
    assert ("torques or model" in measure_gap(record, MODEL, repaired=repaired).warnings) == kept


def test_a_time_limit_ends_the_fits_and_is_told() -> None:
    settings = DiagnosisSettings(time_limit=1e-3)
    tolerance = {"stiffness": 0.03, "inertia": 0.03}
    found = measure_gap(record_of(FRICTION), MODEL, tolerance=tolerance, settings=settings)
    assert found.numbers.before > 20
    assert "the time limit ended the fits of tolerated numbers" in found.warnings[-1]
    assert not any("time limit" in text for text in measure_gap(record_of(FRICTION), MODEL).warnings)


def test_torques_that_acted_elsewhere_are_no_new_measurement(monkeypatch: pytest.MonkeyPatch) -> None:
    """Warnings stand once, the time limit is that of both passes, and the progress never falls."""
    begun: list[Deadline] = []
    calls: list[tuple[str, float]] = []

    def deadline(limit: float | None) -> Deadline:
        begun.append(Deadline(limit))
        return begun[-1]

    shifts = iter((-0.5, None))
    monkeypatch.setattr(module, "Deadline", deadline)
    monkeypatch.setattr(module, "shift_of_noted", lambda *_: next(shifts, None))
    monkeypatch.setattr(UnknownNumbers, "warnings", ("a number is unknown",))
    model = RobotWithEffects(arm(), ())
    found = measure_gap(record_of_arm(imported=True), model, repaired=model, progress=lambda *call: calls.append(call))
    assert found.warnings.count("a number is unknown") == 1
    assert sum("the measured torques fit the motion where each was held" in text for text in found.warnings) == 1
    assert len(begun) == 1
    assert [name for name, _ in groupby(name for name, _ in calls)] == ["nominal model", "repaired model"] * 2
    shares = [share for _, share in calls]
    assert shares == sorted(shares)


@pytest.mark.parametrize(("level", "torque", "hidden"), [
    (0.05, None, True), (0.05, 0.05, False), (0.0, None, False),
])  # fmt: skip
def test_what_an_assumed_tolerance_of_torques_hides_is_measured(
    level: float, torque: float | None, hidden: bool
) -> None:
    """Six large effects were no gap within the 5 % that nobody stated."""
    effects = (f"coulomb_friction@motor_1:level={level}",) if level else ()
    record = replace(record_of(*effects), simulated=False, imported=True)
    found = measure_gap(record, MODEL, tolerance=None if torque is None else {"torque": torque})
    assert not found.significant
    assert found.left.assumed == (0.05 if hidden else None)
    stated = measure_gap(record, MODEL, tolerance={"torque": 0.005})
    assert found.left.if_known == (stated.numbers.before if hidden else None)


def test_a_prediction_that_diverges_with_better_torques_leaves_the_gap_as_it_is(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def weighed(record: Record, model: RobotWithEffects, settings: DiagnosisSettings) -> FitData:
        if settings.noise.signal_tolerance < 0.05:
            raise InputError("the prediction of the nominal model diverges")
        return fit_data(record, model, settings)

    monkeypatch.setattr(module, "fit_data", weighed)
    found = measure_gap(replace(record_of(FRICTION), simulated=False, imported=True), MODEL)
    assert not found.significant
    assert found.left.assumed is None


@pytest.mark.parametrize(("far", "gap"), [({}, False), ({"motor_1.inertia": 1.22}, True)])
def test_what_a_real_machine_may_leave_is_a_gap_beside_a_number_far_out_of_its_tolerance(
    far: dict[str, float], gap: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "far_out", lambda *_, **__: far)
    record = replace(record_of("motor_inertia_error@motor_1:relative=0.3"), simulated=False, imported=True)
    left = measure_gap(record, MODEL, tolerance={"inertia": 0.04, "torque": 0.01}).left
    assert left.most < left.level < 2.0
    assert left.strained == tuple(far)
    assert left.significant is gap
