from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from flexros.analysis import analyse
from flexros.analysis.figures_table import figure_rows
from flexros.analysis.loop_timing import loop_timing
from flexros.analysis.pace import Pacing, arrival_timing, plant_pacing, ran_in_real_time

FIGURES = {
    "samples": 1001.0,
    "missed_commands": 3.0,
    "cycles": 1001.0,
    "rate_hz": 1999.9,
    "period_p50_us": 500.0,
    "period_p99_us": 540.0,
    "period_max_us": 1500.0,
    "lateness_p99_us": 70.0,
    "lateness_max_us": 1020.0,
    "late": 35.0,
    "late_percent": 3.5,
}
"""Diagnostics of the plant node in a run in real time."""


def test_periods_of_receipt():
    late = np.zeros(1000, dtype=np.int64)
    late[500] = 400_000
    timing = arrival_timing("joint_states", 10**9 + np.arange(1000) * 500_000 + late)
    assert timing.period_median == pytest.approx(5e-4)
    assert timing.mean_period == pytest.approx(5e-4)
    assert timing.period_p99 == pytest.approx(5e-4)
    assert timing.period_max == pytest.approx(9e-4)
    assert timing.jitter_std == pytest.approx(4e-4 * np.sqrt(2 / 999), rel=1e-6)
    assert timing.step_time[-1] == pytest.approx(999 * 5e-4)


def test_messages_that_overtake_each_other_have_no_negative_period():
    received = 10**9 + np.array([0, 3, 2, 5], dtype=np.int64)
    assert arrival_timing("joint_states", received).steps.min() > 0.0


def test_one_message_has_no_period():
    assert arrival_timing("joint_states", np.array([10**9])) is None


def test_figures_of_the_plant_in_si_units():
    pacing = plant_pacing(FIGURES)
    assert pacing == Pacing(
        cycles=1001,
        rate=1999.9,
        period_median=pytest.approx(500e-6),
        period_p99=pytest.approx(540e-6),
        period_max=pytest.approx(1500e-6),
        lateness_p99=pytest.approx(70e-6),
        lateness_max=pytest.approx(1020e-6),
        late_share=pytest.approx(0.035),
        missed_commands=3,
    )


def test_a_plant_that_reported_half_leaves_the_rest_open():
    assert plant_pacing({"missed_commands": 2.0}) == Pacing(missed_commands=2)


def test_in_lock_step_the_plant_keeps_no_schedule():
    assert plant_pacing({"samples": 1001.0, "resends": 0.0}) is None


def received(log, delay=0.0):
    """The log as a recorder took it in real time, each message up to 50 us late."""
    late = np.rint(np.random.default_rng(4).uniform(delay, delay + 50e-6, len(log.joint_states.stamp)) * 1e9)
    states = replace(log.joint_states, received=log.joint_states.stamp + late.astype(np.int64))
    return replace(log, joint_states=states)


def test_the_provenance_says_whether_it_was_real_time(make_run):
    log = make_run()
    assert ran_in_real_time(replace(log, provenance={"real_time": True})) is True
    assert ran_in_real_time(replace(received(log), provenance={"real_time": False})) is False


def test_without_provenance_the_log_itself_decides(make_run):
    log = make_run()
    assert ran_in_real_time(received(log)) is True
    assert ran_in_real_time(replace(log, plant_figures=FIGURES)) is True
    assert ran_in_real_time(log) is False, "a scenario without receipt times"
    assert ran_in_real_time(replace(log, provenance={})) is None, "anything that was imported"


def test_the_timing_of_a_log_holds_its_pace(make_run):
    timing = loop_timing(replace(received(make_run(), 1e-3), plant_figures=FIGURES))
    assert timing.real_time
    assert timing.pacing.missed_commands == 3
    assert timing.arrival("joint_states").jitter_std == pytest.approx(50e-6 / np.sqrt(6), rel=0.1)
    assert timing.arrival("joint_commands") is None
    assert timing.exact, "of the stamps none is missing"


def test_json_holds_the_pace(make_run):
    analysis = analyse(replace(received(make_run()), plant_figures=FIGURES))
    timing = json.loads(json.dumps(analysis.as_dict(), allow_nan=False))["timing"]
    assert timing["real_time"] is True
    assert timing["received"]["joint_states"]["period_max_s"] == analysis.timing.arrivals[0].period_max
    assert timing["pacing"]["late_share"] == pytest.approx(0.035)
    still = loop_timing(make_run()).as_dict()
    assert (still["real_time"], still["received"], still["pacing"]) == (False, {}, None)


def test_table_shows_the_pace_and_not_the_exact_stamps(make_run):
    analysis = analyse(replace(received(make_run()), plant_figures=FIGURES))
    values = {row.name: row.values[0] for row in figure_rows([analysis]) if row.group == "Timing"}
    assert values["real time (no: lock-step)"] == "yes"
    assert values["plant, late cycles"] == "3.500"
    assert values["plant, missed commands"] == "3"
    assert values["plant, start after due, max"] == "1020"
    assert float(values["joint_states, received period, median"]) == pytest.approx(0.5, rel=0.02)
    assert not any("commands, jitter" in name for name in values), "of its receipt nothing is known"
    assert figure_rows([analyse(make_run())])[-3].name == "joint_commands, jitter max"
