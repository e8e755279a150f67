"""Diagnosis of a measured drive: EMPS of Janot, Gautier and Brunot (2019), which is not in this repository."""

from __future__ import annotations

import os
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.gap import explain
from flexros.gap.checked_record import CheckedRecord
from flexros.gap.diagnose import diagnose
from flexros.gap.noise import SIGNAL_TOLERANCE, measure_noise
from flexros.gap.read_record import read_record
from flexros.gap.record import GapRecord
from flexros.gap.settings import DiagnosisSettings
from flexros.logs.foreign.import_log import import_log
from flexros.logs.foreign.mapping import load_mapping
from flexros.logs.time_series import Log
from flexros.robot import Robot, load_robot

REALDATA = os.environ.get("FLEXROS_REALDATA", "")
pytestmark = pytest.mark.skipif(
    not REALDATA or not (Path(REALDATA) / "emps").is_dir(),
    reason="FLEXROS_REALDATA is unset or names no folder with emps/, the measured drive",
)


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load_robot("emps")


@cache
def log_of(name: str) -> Log:
    return import_log(load_mapping("emps"), [Path(REALDATA) / "emps" / name])


@cache
def record_of(name: str) -> GapRecord:
    return read_record(log_of(name), load_robot("emps"), name=name)


@pytest.mark.parametrize("name", ["DATA_EMPS.mat", "DATA_EMPS_PULSES.mat"])
def test_measured_log_passes_the_checks(robot: Robot, name: str) -> None:
    record = record_of(name)
    assert (record.n_samples, record.sample_time) == (24841, 1e-3)
    assert record.valid.all()
    assert not record.simulated
    assert record.imported
    assert record.reference is not None
    assert not any("robot emps" in text or "torque" in text for text in record.warnings)
    checked = CheckedRecord(record, robot)
    assert checked.own[0].factor == pytest.approx(1.0, abs=0.1)
    assert checked.own[0].agreement > 0.8
    assert abs(checked.delay.time) < 5e-4


def test_measured_log_gets_a_signal_tolerance_and_a_plausible_noise(robot: Robot) -> None:
    noise = measure_noise(record_of("DATA_EMPS.mat"), robot)
    assert noise.signal_tolerance == SIGNAL_TOLERANCE
    assert noise.standard_deviation[0] == robot.encoder_noise[0]


@pytest.mark.parametrize(
    ("factor", "words"), [(-1.0, "inverted"), (1000.0, "milli"), (1 / 351.506 * 100, "% of the limit")]
)
def test_spoilt_measured_log_is_refused(robot: Robot, factor: float, words: str) -> None:
    log = log_of("DATA_EMPS.mat")
    commands = replace(log.joint_commands, effort=factor * log.joint_commands.effort)
    with pytest.raises(InputError, match=rf"^emps: .*{words}"):
        read_record(replace(log, joint_commands=commands), robot, name="emps")


def test_coulomb_friction_is_named_first_with_its_published_level(
    robot: Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The published level is 20.39 N, and an offset of -3.16 N is the asymmetry of it."""
    monkeypatch.setattr(explain, "MOST_EFFECTS", 2)  # a third one takes as long as all before
    settings = DiagnosisSettings(where=False, next_experiment=False)
    result = diagnose(record_of("DATA_EMPS.mat").part(0, 8000), robot, settings=settings)
    first = result.diagnosis.causes[0]
    assert (first.effect, first.location) == ("coulomb_friction", "motor_1")
    assert first.parameters["level"].value == pytest.approx(20.39, rel=0.1)
    named = {cause.effect for cause in result.diagnosis.causes if cause.probability > 0.5}
    assert not named & {"backlash", "delay", "stribeck_friction", "actuator_lag"}
    assert np.isfinite(first.closed_fraction)
    assert first.closed_fraction > 0.9
