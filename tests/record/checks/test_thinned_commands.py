"""Logs that hold only some commands of their controller."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.logs.time_series import JointSeries, Log
from flexros.record.checks.run import findings
from flexros.record.read import read_record
from flexros.robot import load_robot
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario


@pytest.fixture(scope="module")
def log() -> Log:
    scenario = load_scenario("diagnosis").with_values({"robot": "e12", "diagnosis.length": 10.0}, "test")
    return closed_loop(Experiment.prepare(scenario))


def every(series: JointSeries | None, n: int) -> JointSeries:
    """Keep one of n messages."""
    assert series is not None
    values = {field: getattr(series, field) for field in ("position", "velocity", "effort")}
    kept = {field: None if value is None else value[::n] for field, value in values.items()}
    return JointSeries(series.stamp[::n], series.names, **kept)


@pytest.mark.parametrize("n", [2, 4])
def test_thinned_log_is_refused_for_its_cause(log: Log, n: int) -> None:
    thin = replace(log, joint_states=every(log.joint_states, n), joint_commands=every(log.joint_commands, n))
    robot = load_robot("e12")
    first, *_ = findings(read_record(thin, robot, name="thin"), robot)
    assert first.hopeless
    assert first.like_parameters  # an identification, at lower frequencies, may use it
    assert f"one of {n} commands" in first.text
    assert "time_offset" not in first.text


def test_log_of_unknown_origin_is_told_both_causes(log: Log) -> None:
    thin = replace(
        log, joint_states=every(log.joint_states, 4), joint_commands=every(log.joint_commands, 4), provenance={}
    )
    robot = load_robot("e12")
    texts = [finding.text for finding in findings(read_record(thin, robot, name="thin"), robot)]
    assert any("one of 4 commands of a controller at 2000 Hz" in text and "time_offset" in text for text in texts)


def test_of_measured_torques_no_command_was_left_out(log: Log) -> None:
    thin = replace(
        log, joint_states=every(log.joint_states, 4), joint_commands=every(log.joint_commands, 4), provenance={}
    )
    robot = load_robot("e12")
    record = replace(read_record(thin, robot, name="thin"), measured_torque=True)
    texts = [finding.text for finding in findings(record, robot)]
    assert any("stamped too late" in text for text in texts)
    assert not any("commands of a controller" in text for text in texts)


def test_all_commands_beside_fewer_measurements_are_averaged(log: Log) -> None:
    robot = load_robot("e12")
    record = read_record(replace(log, joint_states=every(log.joint_states, 4)), robot, name="log")
    commands = log.joint_commands
    assert commands is not None
    assert commands.effort is not None
    n = len(commands.effort) // 4 - 1
    means = commands.effort[: 4 * n].reshape(n, 4, 2).mean(axis=1)
    np.testing.assert_allclose(record.torque[:n], means, rtol=1e-9, atol=1e-6)
    assert record.thinned == pytest.approx(1.0)
    assert not any("precede" in finding.text for finding in findings(record, robot))
