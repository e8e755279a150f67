"""Section of frequency responses, and the summary of an identification experiment."""

from __future__ import annotations

from dataclasses import replace

import pytest

from flexros.analysis import Analysis, analyse
from flexros.analysis.report.frequency_responses import FrequencyResponseSection
from flexros.analysis.report.summary import SummarySection, verdict
from flexros.logs.time_series import Log
from flexros.report.base import Paragraph, Picture, TextTable

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module", name="experiment")
def fixture_experiment(experiment_log: Log) -> Analysis:
    return analyse(experiment_log)


def test_responses_and_distortions_are_drawn_by_position(experiment: Analysis) -> None:
    blocks = FrequencyResponseSection().blocks([experiment])
    responses, distortions = (block.figure for block in blocks if isinstance(block, Picture))
    assert len(responses.data) == 4 * 3
    assert [button.label for button in responses.layout.updatemenus[1].buttons] == [
        "position 1 (0.00, 0.30)",
        "position 2 (0.10, 0.50)",
    ]
    assert {trace.name for trace in distortions.data} >= {"output", "noise", "odd distortion", "even distortion"}


def test_table_has_the_deviation_of_every_motor(experiment: Analysis) -> None:
    blocks = FrequencyResponseSection().blocks([experiment])
    table = next(block for block in blocks if isinstance(block, TextTable))
    assert [row[0] for row in table.rows] == ["position 1 (0.00, 0.30)", "position 2 (0.10, 0.50)"]
    assert experiment.responses is not None
    share = experiment.responses.as_dict()["positions"][1]["relative_std_diagonal"]["motor_2"]
    assert float(table.rows[1][-1]) == pytest.approx(100 * share, rel=0.01)


def test_several_runs_are_distinguished_and_others_left_out(experiment: Analysis, make_run) -> None:
    other = analyse(make_run(), label="circle")
    blocks = FrequencyResponseSection().blocks([other, replace(experiment, label="a"), replace(experiment, label="b")])
    texts = [block.text for block in blocks if isinstance(block, Paragraph)]
    assert texts[0].startswith("a: Best linear approximation from torque commands to motor accelerations in 2 pos")
    assert sum(text.startswith("b: ") for text in texts) == 1
    assert FrequencyResponseSection().blocks([other]) == ()


def test_warnings_of_the_record_are_in_the_section(experiment_log: Log, experiment: Analysis) -> None:
    assert experiment.responses is not None
    spoilt = replace(experiment.responses.positions[0], warnings=("the clock stood still",))
    blocks = FrequencyResponseSection().blocks(
        [replace(experiment, responses=replace(experiment.responses, positions=(spoilt,)))]
    )
    assert Paragraph("Warning: the clock stood still.", "note") in blocks


def test_reason_is_shown_where_there_are_no_responses(experiment_log: Log) -> None:
    analysis = analyse(replace(experiment_log, joint_commands=None))
    (only,) = FrequencyResponseSection().blocks([analysis])
    assert isinstance(only, Paragraph)
    assert only.text.startswith("The frequency responses were not estimated: ")
    assert "joint_commands" in only.text
    assert verdict([analysis]).startswith(
        "An identification experiment whose frequency responses were not estimated; the"
    )


def test_summary_is_that_of_an_experiment(experiment: Analysis) -> None:
    lead, tiles = SummarySection().blocks([experiment])
    assert isinstance(lead, Paragraph)
    assert lead.text.startswith(
        "An identification experiment: frequency responses of 2 motors in 2 positions from 3 to 39 Hz; the motors "
    )
    assert tiles.items[0][0] == "Standard deviation of the responses"  # type: ignore[union-attr]
    assert verdict([experiment, experiment]).startswith("2 runs, none with a path: only the motor side is evaluated")
