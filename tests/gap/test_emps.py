"""Diagnosis of a measured drive: EMPS of Janot, Gautier and Brunot (2019), which is not in this repository."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from flexros.effects import RobotWithEffects
from flexros.errors import InputError
from flexros.gap.candidates.candidate import Candidate
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.checked_log import checked_log
from flexros.gap.diagnose import diagnose
from flexros.gap.fit.candidate_fit import CandidateFit, best_of
from flexros.gap.fit.initial_values import initial_values
from flexros.gap.fit.least_squares import fit
from flexros.gap.fit.null_fit import NullFit, fit_null
from flexros.gap.fit.sum_of_squares import chi2_of
from flexros.gap.noise.encoder_noise import measure_noise
from flexros.gap.residuals.prepare_fit_data import fit_data
from flexros.gap.search.prepare import prepare_search
from flexros.gap.settings import DiagnosisSettings, SearchSettings
from flexros.logs.foreign.import_log import import_log
from flexros.logs.foreign.mapping import load_mapping
from flexros.logs.time_series import Log
from flexros.record.checks.checked_record import CheckedRecord
from flexros.record.record import Record
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
def record_of(name: str) -> Record:
    return checked_log(log_of(name), load_robot("emps"), name=name)


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
    noise = measure_noise(record_of("DATA_EMPS.mat"), robot, DiagnosisSettings())
    assert noise.signal_tolerance == DiagnosisSettings().noise.signal_tolerance
    assert noise.standard_deviation[0] == robot.encoder_noise[0]


@pytest.mark.parametrize(
    ("factor", "words"), [(-1.0, "inverted"), (1000.0, "milli"), (1 / 351.506 * 100, "% of the limit")]
)
def test_spoilt_measured_log_is_refused(robot: Robot, factor: float, words: str) -> None:
    log = log_of("DATA_EMPS.mat")
    commands = replace(log.joint_commands, effort=factor * log.joint_commands.effort)
    with pytest.raises(InputError, match=rf"^emps: .*{words}"):
        checked_log(replace(log, joint_commands=commands), robot, name="emps")


@pytest.mark.slow
def test_coulomb_friction_is_named_first_with_its_published_level(robot: Robot) -> None:
    """The published level is 20.39 N, and an offset of -3.16 N is the asymmetry of it."""
    pairs = SearchSettings(most_effects=2)  # a third one takes as long as all before
    settings = DiagnosisSettings(where=None, next_experiment=None, search=pairs)
    result = diagnose(record_of("DATA_EMPS.mat").part(0, 8000), robot, settings=settings)
    first = result.diagnosis.causes[0]
    assert (first.effect, first.location) == ("coulomb_friction", "motor_1")
    assert first.parameters["level"].value == pytest.approx(20.39, rel=0.1)
    named = {cause.effect for cause in result.diagnosis.causes if cause.probability > 0.5}
    assert not named & {"backlash", "delay", "stribeck_friction", "actuator_lag"}
    assert np.isfinite(first.closed_fraction)
    assert first.closed_fraction > 0.9


Pulses = tuple[NullFit, CandidateFit, Mapping[str, Candidate]]


@pytest.fixture(scope="module")
def under_pulses(robot: Robot) -> Pulses:
    """Fit Coulomb and viscous friction to 8 s of the log with pulses."""
    model = RobotWithEffects(robot, ())
    data = fit_data(record_of("DATA_EMPS_PULSES.mat").part(0, 8000), model, DiagnosisSettings())
    null = fit_null(data, model, Tolerance())
    among = {candidate.name: candidate for candidate in prepare_search(null).candidates()}
    predictor = null.predictor((among["coulomb_friction@motor_1"], among["viscous_friction@motor_1"]))
    starts = initial_values(predictor)
    best = np.argsort(chi2_of(predictor, data, starts))[:3]
    return null, best_of([fit(predictor, data, starts[:, one], 30) for one in best]), among


def test_pulses_show_the_published_friction(
    under_pulses: Pulses,
) -> None:
    null, friction, _ = under_pulses
    coulomb, viscous = friction.predictor.values(friction.theta)
    assert coulomb["level"] == pytest.approx(20.39, rel=0.1)
    assert viscous["asymmetry"] == pytest.approx((166.7 - 240.4) / 203.6, rel=0.2)
    assert friction.chi2 < 0.02 * null.fit.chi2


def test_pulses_leave_no_ringing(under_pulses: Pulses) -> None:
    """A flexibility that the pulses excite would show in the errors after their edges, from 344 ms on each 500 ms."""
    null, friction, _ = under_pulses
    errors = friction.residual(null.data)
    after = np.arange(len(errors)) % 500
    ringing = (after >= 344) & (after < 404)
    assert np.mean(errors[ringing] ** 2) < 1.2 * np.mean(errors**2)


@pytest.mark.parametrize("name", ["extra_mode@tool", "delay@all", "actuator_lag@motor_1"])
def test_pulses_need_no_mode_and_no_delay(under_pulses: Pulses, name: str) -> None:
    """The authors assume a flexibility; docs/results/emps.md has the figures."""
    null, friction, among = under_pulses
    predictor = null.predictor((*friction.predictor.hypothesis, among[name]))
    starts = initial_values(null.predictor((among[name],)))
    starts = np.vstack([np.repeat(friction.theta[:, None], starts.shape[1], axis=1), starts])
    best = np.argsort(chi2_of(predictor, null.data, starts))[:2]
    more = best_of([fit(predictor, null.data, starts[:, one], 12) for one in best])
    assert more.chi2 > (1 - SearchSettings().removed_of_all) * friction.chi2
