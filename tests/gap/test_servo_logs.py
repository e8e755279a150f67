"""Gap and diagnosis of logs with position commands only."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.effects import RobotWithEffects, parse_effect, place_effects
from flexros.errors import InputError
from flexros.gap.checked_log import checked_log
from flexros.gap.diagnose import diagnose
from flexros.gap.measure_gap import measure_gap
from flexros.record.record import Record
from tests.gap.diagnosis_logs import settings_of
from tests.gap.servo_logs import servo_log, servo_robot

pytestmark = pytest.mark.slow

MODEL = RobotWithEffects(servo_robot(), ())
ZERO = "encoder_offset@motor_1:offset=0.1"
STIFF, FRICTION = "servo_stiffness_error@motor_1:relative=-0.2", "coulomb_friction@motor_1:level=0.25"


def record_of(*effects: str, seed: int = 0) -> Record:
    return checked_log(servo_log(*effects, seed=seed), MODEL.robot, name="log")


def test_exact_model_has_no_gap() -> None:
    found = measure_gap(record_of(), MODEL)
    assert found.numbers.before == pytest.approx(1.0, abs=0.3)
    assert not found.significant


def test_the_floor_with_tolerance_is_that_of_positions_that_cause_such_torques() -> None:
    floor = measure_gap(replace(record_of(), imported=True), MODEL).numbers.tolerance_floor
    assert floor is not None
    assert 1.5 < floor < 1000


def test_a_repair_closes_the_gap_of_a_wrong_gain() -> None:
    repaired = place_effects(MODEL.robot, [parse_effect(STIFF, "test")])
    found = measure_gap(record_of(STIFF), MODEL, repaired=repaired)
    assert found.numbers.before > 10
    assert found.numbers.after == pytest.approx(1.0, abs=0.3)
    assert not found.significant


def test_gain_and_friction_are_named() -> None:
    logs = [record_of(STIFF, FRICTION, seed=seed) for seed in (0, 5)]
    result = diagnose(logs[0], MODEL, holdout=logs[1], settings=settings_of())
    causes = {cause.effect: cause for cause in result.diagnosis.causes if cause.probability > 0.5}
    assert set(causes) == {"servo_stiffness_error", "coulomb_friction"}
    assert causes["servo_stiffness_error"].parameters["relative"].value == pytest.approx(-0.2, abs=0.02)
    assert causes["coulomb_friction"].parameters["level"].value == pytest.approx(0.25, rel=0.05)
    assert result.diagnosis.gap.closed_fraction == pytest.approx(1.0, abs=0.02)
    assert any("position commands" in text for text in result.limits)
    numbers = {number.name: number for number in result.diagnosis.model_numbers}
    assert numbers["motor_1.servo_stiffness"].value == pytest.approx(48.0, rel=0.03)


def test_another_zero_of_the_encoder_is_named_beside_gain_and_friction() -> None:
    logs = [replace(record_of(STIFF, FRICTION, ZERO, seed=seed), imported=True) for seed in (0, 5)]
    others = ("coulomb_friction", "servo_stiffness_error", "gravity_error", "torque_bias")
    settings = settings_of(*others, "encoder_offset")
    found = diagnose(logs[0], MODEL, holdout=logs[1], settings=settings).diagnosis
    causes = {cause.effect: cause for cause in found.causes if cause.probability > 0.5}
    assert set(causes) == {"servo_stiffness_error", "coulomb_friction", "encoder_offset"}
    assert causes["encoder_offset"].parameters["offset"].value == pytest.approx(0.1, abs=0.005)


def test_a_rotor_that_the_file_leaves_out_is_found() -> None:
    bare = RobotWithEffects(servo_robot().with_values({"motor_1.inertia": 0.0}).commanded_by("position"), ())
    logs = [replace(record_of(FRICTION, seed=seed), imported=True) for seed in (0, 5)]
    settings = settings_of("coulomb_friction", "viscous_friction", "servo_stiffness_error", "rotor_inertia")
    found = diagnose(logs[0], bare, holdout=logs[1], settings=settings).diagnosis
    causes = {cause.effect: cause for cause in found.causes if cause.probability > 0.5}
    assert set(causes) == {"coulomb_friction", "rotor_inertia"}
    assert causes["rotor_inertia"].parameters["added"].value == pytest.approx(0.05, rel=0.1)
    assert causes["rotor_inertia"].parameters["added"].unit == "kg m2"


def test_torque_logs_are_independent_of_a_servo_in_the_file() -> None:
    log = servo_log()
    assert log.joint_commands is not None
    effort = np.random.default_rng(1).normal(size=log.joint_states.position.shape)  # type: ignore[union-attr]
    torque = replace(log, joint_commands=replace(log.joint_commands, position=None, effort=effort))
    found = []
    for robot in (servo_robot(), servo_robot(servo=False)):
        record = replace(checked_log(torque, robot, name="log"), warnings=())
        found.append(measure_gap(record, RobotWithEffects(robot, ())).numbers.before)
    assert found[0] == found[1]


def test_holdout_with_torques_is_refused() -> None:
    record = record_of()
    with pytest.raises(InputError, match="commanded positions"):
        diagnose(record, MODEL, holdout=replace(record, command=None))
