"""The experiment of a log, from its provenance, and where its multisines lie."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from flexros.gap.checked_log import checked_log
from flexros.logs.time_series import JointSeries, Log
from flexros.record.read import read_record
from flexros.robot import load_robot
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.recorded_experiment import recorded_experiment, with_recorded_parts
from flexros.scenario.scenario import load_scenario

pytestmark = pytest.mark.slow

ROBOT = load_robot("four_mass_linear")
CUT = 1234


@cache
def experiment_log() -> Log:
    keys = {"robot": ROBOT.name, "plant.effects": ["coulomb_friction@motor_1:level=0.05"]}
    return closed_loop(Experiment.prepare(load_scenario("diagnosis").with_values(keys, "test")))


def cut(series: JointSeries | None) -> JointSeries:
    assert series is not None
    columns = {
        name: None if (values := getattr(series, name)) is None else values[CUT:]
        for name in ("position", "velocity", "effort")
    }
    return JointSeries(series.stamp[CUT:], series.names, **columns)


def test_the_experiment_is_made_again_without_what_was_hidden() -> None:
    log = experiment_log()
    experiment = recorded_experiment(log)
    assert experiment is not None
    assert not experiment.scenario.noise
    assert experiment.scenario.plant.effects == ()
    assert experiment.n_samples == len(log.joint_states.stamp)


@pytest.mark.parametrize("provenance", [{}, {"scenario": "circle"}, {"scenario": {"robot": "nowhere.yaml"}}])
def test_a_log_that_names_no_scenario_of_this_machine_has_none(provenance: dict[str, object]) -> None:
    log = replace(experiment_log(), provenance=provenance)
    assert recorded_experiment(log) is None
    assert with_recorded_parts(read_record(log, ROBOT, name="log"), log).parts == ()


def test_multisines_are_found_at_the_same_samples_of_a_log_that_begins_later() -> None:
    log = experiment_log()
    late = replace(
        log, joint_states=cut(log.joint_states), joint_commands=cut(log.joint_commands), joint_reference=None
    )
    whole, part = (checked_log(one, ROBOT, name="log") for one in (log, late))
    assert len(whole.parts) >= 3
    kept = [(one.first - CUT, one.n_periods) for one in whole.parts if one.first >= CUT]
    assert [(one.first, one.n_periods) for one in part.parts][-len(kept) :] == kept
    for one in whole.parts:
        periods = whole.position[one.first : one.end].reshape(one.n_periods, one.period, -1)
        assert np.abs(np.diff(periods, axis=0)).max() < 0.05 * np.ptp(periods)


def test_parts_of_a_record_keep_their_multisines() -> None:
    record = checked_log(experiment_log(), ROBOT, name="log")
    border = record.parts[1].first
    before, after = record.part(0, border), record.part(border, record.n_samples)
    assert [one.first for one in before.parts] == [one.first for one in record.parts if one.end <= border]
    assert after.parts[0].first == 0
    assert after.begin == pytest.approx(border * record.sample_time)
