"""Frequency responses out of the log of an identification experiment."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from flexros.analysis import analyse
from flexros.analysis.figures_table import figure_rows
from flexros.analysis.frequency_responses import log_responses, relative_deviation
from flexros.identify.frf.positions import estimate_responses
from flexros.logs.time_series import Log
from flexros.scenario.identification_plan import plan_of_log
from tests.identify.frf.recorded_experiment import cut

pytestmark = pytest.mark.slow


def test_responses_are_those_of_the_estimation(experiment_log: Log) -> None:
    analysis = analyse(experiment_log)
    assert analysis.responses is not None
    expected = estimate_responses(experiment_log, plan_of_log(experiment_log))
    for mine, theirs in zip(analysis.responses.positions, expected, strict=True):
        np.testing.assert_array_equal(mine.response, theirs.response)


def test_record_for_json_names_positions_lines_band_and_deviation(experiment_log: Log) -> None:
    record = json.loads(json.dumps(analyse(experiment_log).as_dict()["frequency_responses"]))
    first, second = record["positions"]
    assert second["gears"] == [0.1, 0.5]
    assert (first["lowest_hz"], first["highest_hz"], first["blocks"], first["periods"]) == (3.0, 39.0, 2, 2)
    assert first["lines"] > 10
    assert set(first["relative_std_diagonal"]) == {"motor_1", "motor_2"}
    assert 0 < first["relative_std_diagonal"]["motor_1"] < 0.05
    assert isinstance(first["warnings"], list)


def test_excitation_is_no_path(experiment_log: Log) -> None:
    assert experiment_log.tool_reference is not None
    analysis = analyse(experiment_log)
    assert (analysis.path, analysis.performance, analysis.corners) == (None, None, ())
    assert not any("path" in warning or "tool" in warning for warning in analysis.warnings)


def test_deviation_is_a_figure_of_the_run(experiment_log: Log) -> None:
    analysis = analyse(experiment_log)
    assert analysis.responses is not None
    rows = {(row.group, row.name): float(row.values[0]) for row in figure_rows([analysis]) if row.group == "Responses"}
    assert rows["Responses", "positions"] == 2
    shares = [relative_deviation(response)["motor_1"] for response in analysis.responses.positions]
    expected = 100 * np.median(shares)  # type: ignore[arg-type]
    np.testing.assert_allclose(rows["Responses", "motor_1, standard deviation, median"], expected, rtol=1e-3)


def test_complete_blocks_of_a_log_that_was_aborted_are_used(experiment_log: Log) -> None:
    plan = plan_of_log(experiment_log)
    analysis = analyse(cut(experiment_log, slice(0, plan.segments[-1].stop - 100)))
    assert analysis.responses is not None
    assert [response.n_blocks for response in analysis.responses.positions] == [2, 1]
    assert any(text.startswith("the log ends before its plan; 1 incomplete blocks") for text in analysis.warnings)
    assert any("samples of its run, which was aborted" in text for text in analysis.warnings)


def test_stopped_experiment_is_said_to_be_stopped(experiment_log: Log) -> None:
    at = plan_of_log(experiment_log).segments[-1].first
    stopped = {"stopped_at_sample": at, "completed": 7, "planned": 8}
    log = replace(experiment_log, provenance={**experiment_log.provenance, "stopped": stopped})
    warnings = analyse(log).warnings
    assert "the experiment was stopped when 7 of 8 experiments were complete" in warnings
    assert not any("aborted" in text for text in warnings)


def test_log_whose_responses_cannot_be_estimated_is_analysed_without(experiment_log: Log) -> None:
    analysis = analyse(replace(experiment_log, joint_commands=None))
    assert analysis.responses is not None
    assert analysis.responses.positions == ()
    assert analysis.as_dict()["frequency_responses"] == {"positions": []}
    assert any(
        text.startswith("the frequency responses were not estimated: ") and "joint_commands" in text
        for text in analysis.warnings
    )


def test_other_logs_have_none(make_run) -> None:
    assert log_responses(make_run()) is None
    assert log_responses(replace(make_run(), provenance={"scenario": {"name": "circle_pd", "robot": "e12"}})) is None
    assert analyse(make_run()).as_dict()["frequency_responses"] is None
