"""Measures of recorded runs."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from flexros.benchmark.evaluate import FeedbackBenchmark
from flexros.benchmark.models import NOMINAL
from flexros.benchmark.recorded import is_recording, recorded_run
from flexros.errors import InputError
from flexros.logs.write_log import write_log
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario


@pytest.mark.slow
def test_recorded_run_has_the_cost_of_the_benchmark(tmp_path: Path) -> None:
    scenario = load_scenario("feedback_benchmark")
    write_log(closed_loop(Experiment.prepare(scenario)), tmp_path / "log")
    assert is_recording(str(tmp_path / "log"))
    runs = FeedbackBenchmark().measures_of_set(NOMINAL, scenario.controller, seeds=(scenario.seed,))
    assert recorded_run(tmp_path / "log").measures.cost == runs[0].cost


def test_short_run_is_refused(tmp_path: Path) -> None:
    scenario = load_scenario("feedback_benchmark").with_values({"duration": 1.0})
    log = closed_loop(Experiment.prepare(scenario))
    write_log(log, tmp_path / "short")
    with pytest.raises(InputError, match="2001 samples"):
        recorded_run(tmp_path / "short")
    write_log(replace(log, tool_pose=None), tmp_path / "partial")
    with pytest.raises(InputError, match="tool_pose"):
        recorded_run(tmp_path / "partial")
