"""Diagnosis and identification take the same record out of the same log."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from flexros.gap.checked_log import UNKNOWN_ORIGIN, checked_log
from flexros.identify.axis.record import axis_record
from flexros.identify.log_record import log_record
from flexros.identify.rigid.base_parameters import base_parameters
from flexros.identify.rigid.fit import fit_rigid, rows_of_log
from flexros.identify.rigid.regressor import RigidRegressor
from flexros.identify.rigid.settings import RigidSettings
from flexros.logs.time_series import JointSeries, Log
from flexros.record.record import Record
from flexros.robot import load_robot
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario

pytestmark = pytest.mark.slow

E12 = load_robot("e12")
SLOW = RigidSettings(cutoff=20.0)
SAMPLES = 10_000


@cache
def recorded() -> Log:
    """Record the first 5 s of a diagnosis experiment."""
    scenario = load_scenario("diagnosis").with_values({"robot": "e12", "diagnosis.length": 10.0}, "test")
    log = closed_loop(Experiment.prepare(scenario))
    first, commands = np.arange(SAMPLES), log.joint_commands
    assert commands is not None
    return replace(log, joint_states=rows(log.joint_states, first), joint_commands=rows(commands, first))


@pytest.fixture(scope="module")
def log() -> Log:
    return recorded()


@cache
def diagnosed_in(change: Callable[[Log], Log]) -> Record:
    return checked_log(change(recorded()), E12, name="log")


def as_recorded(log: Log) -> Log:
    return log


def foreign_names(log: Log) -> Log:
    """Joints of a foreign robot, in another order in each topic."""
    states, commands = log.joint_states, log.joint_commands
    assert commands is not None
    turned = replace(commands, names=("axis_b", "axis_a"), effort=commands.effort[:, ::-1].copy())
    return replace(log, joint_states=replace(states, names=("axis_a", "axis_b")), joint_commands=turned)


def rows(series: JointSeries, keep: np.ndarray) -> JointSeries:
    signals = {name: getattr(series, name) for name in ("position", "velocity", "effort")}
    return replace(
        series, stamp=series.stamp[keep], **{name: part[keep] for name, part in signals.items() if part is not None}
    )


def lost_samples(log: Log) -> Log:
    """A lost measurement, a lost command, a value that is not finite, and 20 measurements lost in a row."""
    n = len(log.joint_states.stamp)
    position = np.array(log.joint_states.position)
    position[6000, 1] = np.nan
    states = replace(log.joint_states, position=position)
    kept = np.delete(np.arange(n), [500, *range(4000, 4020)])
    assert log.joint_commands is not None
    return replace(
        log, joint_states=rows(states, kept), joint_commands=rows(log.joint_commands, np.delete(np.arange(n), 900))
    )


def jitter(log: Log) -> Log:
    """Stamps that are the true instants, 5 % of a sample off."""
    states = log.joint_states
    off = np.random.default_rng(3).normal(scale=0.05, size=len(states.stamp)) * E12.sample_time
    off[0] = 0.0
    assert states.position is not None
    speed = np.gradient(states.position, E12.sample_time, axis=0)
    stamp = states.stamp + np.rint(1e9 * off).astype(np.int64)
    return replace(log, joint_states=replace(states, stamp=stamp, position=states.position + speed * off[:, None]))


def measured_torque(log: Log) -> Log:
    """Measured torques in addition to the commands."""
    assert log.joint_commands is not None
    return replace(log, joint_states=replace(log.joint_states, effort=1.01 * np.array(log.joint_commands.effort)))


def held_torques(log: Log) -> Log:
    """Measured torques that each act until the next one, of a foreign recorder."""
    assert log.joint_commands is not None
    assert log.joint_commands.effort is not None
    states = replace(log.joint_states, effort=np.array(log.joint_commands.effort))
    return replace(log, joint_states=states, joint_commands=None, provenance={"import": {"files": ["log.csv"]}})


def fast_recorder(log: Log) -> Log:
    """Measured torques of a foreign recorder of 4 kHz, twice the rate of the robot, each held until the next one."""
    states, commands = log.joint_states, log.joint_commands
    assert states.position is not None
    assert commands is not None
    assert commands.effort is not None
    stamp = states.stamp[0] + np.arange(2 * len(states.stamp) - 1) * round(0.5e9 * E12.sample_time)
    position = np.column_stack([np.interp(stamp, states.stamp, column) for column in states.position.T])
    effort = np.repeat(commands.effort, 2, axis=0)[: len(stamp)]
    states = JointSeries(stamp, states.names, position, effort=effort)
    return replace(log, joint_states=states, joint_commands=None, provenance={"import": {"files": ["log.csv"]}})


CASES = [as_recorded, foreign_names, lost_samples, jitter, measured_torque, held_torques, fast_recorder]


def of_rigid(log: Log, settings: RigidSettings = SLOW) -> Record:
    regressor = RigidRegressor(E12)
    return rows_of_log(log, settings, "log", regressor, base_parameters(regressor, 2)).record


@pytest.mark.parametrize("change", CASES)
def test_identification_takes_the_record_of_the_diagnosis(log: Log, change) -> None:
    diagnosed, identified = diagnosed_in(change), of_rigid(change(log))
    for signal in ("position", "torque", "valid"):
        np.testing.assert_array_equal(getattr(identified, signal), getattr(diagnosed, signal))
    assert identified.sample_time == diagnosed.sample_time
    assert identified.warnings == diagnosed.warnings
    if change is fast_recorder:  # a recorder above 2 kHz is thinned for all
        assert 1 / identified.sample_time == pytest.approx(1000.0)


@pytest.mark.parametrize("change", CASES)
def test_one_axis_takes_its_signals_from_the_same_record(log: Log, change) -> None:
    record = log_record(change(log), E12, name="log")
    axis = axis_record(record, 1, "position", E12.delay)
    n, first = len(axis.output), 4020 if change is lost_samples else 0
    assert n == record.n_samples - first
    valid = record.valid[first : first + n]
    np.testing.assert_array_equal(axis.torque, record.torque[first : first + n, 1])
    np.testing.assert_array_equal(axis.output[valid], record.position[first : first + n, 1][valid])
    assert axis.valid is None or np.array_equal(axis.valid, valid)


def test_measured_torque_is_an_argument(log: Log) -> None:
    changed = measured_torque(log)
    commanded, measured = (
        fit_rigid(changed, E12, SLOW.model_copy(update={"torque": name})) for name in ("command", "measured")
    )
    assert (commanded.measured_torque, measured.measured_torque) == (False, True)
    np.testing.assert_allclose(
        measured.values, 1.01 * commanded.values, rtol=0.02, atol=3 * np.max(commanded.deviation)
    )


def test_measured_torque_is_the_same_for_diagnosis_and_identification(log: Log) -> None:
    changed = measured_torque(log)
    diagnosed = checked_log(changed, E12, name="log", torque="measured")
    identified = of_rigid(changed, SLOW.model_copy(update={"torque": "measured"}))
    assert diagnosed.measured_torque
    np.testing.assert_array_equal(identified.torque, diagnosed.torque)


def test_a_log_of_unknown_origin_is_said_to_count_as_simulated(log: Log) -> None:
    def told(provenance: dict[str, object]) -> bool:
        return UNKNOWN_ORIGIN in checked_log(replace(log, provenance=provenance), E12, name="log").warnings

    assert UNKNOWN_ORIGIN not in diagnosed_in(as_recorded).warnings
    assert told({})
    assert not told({"import": {"mapping": "log_mapping.yaml"}})
