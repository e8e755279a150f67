"""What every section of the report must keep, and what single ones say."""

from __future__ import annotations

from dataclasses import replace

import pytest

from flexros.analysis import analyse
from flexros.analysis.report.base import Paragraph, Picture, TextTable
from flexros.analysis.report.provenance import ProvenanceSection
from flexros.analysis.report.summary import verdict
from flexros.analysis.report.timing import TimingSection
from flexros.analysis.report.torques import TorqueSection
from flexros.analysis.report.write import RUN_SECTIONS


@pytest.fixture(scope="module")
def runs(make_run):
    return [analyse(make_run(), label="one"), analyse(make_run(cycles=3, jitter=2e-5), label="three")]


@pytest.mark.parametrize("section", RUN_SECTIONS, ids=lambda section: type(section).__name__)
def test_every_section_shows_one_run_and_several(section, runs):
    assert section.blocks(runs[:1])
    assert section.blocks(runs)


@pytest.mark.parametrize("section", RUN_SECTIONS, ids=lambda section: type(section).__name__)
def test_every_section_bears_a_log_of_positions_alone(section, make_run):
    full = make_run()
    bare = replace(full, joint_reference=None, joint_commands=None, tool_pose=None, tool_reference=None, provenance={})
    for block in section.blocks([analyse(bare)]):
        assert not isinstance(block, Picture)


@pytest.mark.parametrize("section", RUN_SECTIONS, ids=lambda section: type(section).__name__)
def test_every_picture_names_the_unit_of_every_titled_axis(section, runs):
    for block in section.blocks(runs):
        if isinstance(block, Picture):
            axes = [block.figure.layout[key] for key in block.figure.to_dict()["layout"] if key[1:5] == "axis"]
            titles = [axis.title.text for axis in axes if axis.title.text]
            assert titles
            assert all("[" in title or title == "number of samples" for title in titles)
            assert block.caption.endswith(".")


def test_verdict_states_error_tracking_feedback_and_timing(runs):
    text = verdict(runs[:1])
    assert text == (
        "The tool stayed within 0.285 mm of its commanded circle of radius 25 mm (rms 0.116 mm); the motors "
        "followed within 1.60 mrad, with at most 8.4 % of the torque from feedback. "
        "No sample is missing and every stamp is exact."
    )


def test_verdict_of_several_runs_names_best_and_worst(make_run):
    runs = [analyse(make_run(error=error), label=name) for name, error in (("pd", 9e-3), ("dae", 3e-4))]
    assert "dae stayed closest to its path, within 0.285 mm; pd left it farthest" in verdict(runs)


def test_exact_timing_is_said_to_be_so_by_construction(runs):
    blocks = TimingSection().blocks(runs[:1])
    assert "exact by construction" in next(b.text for b in blocks if isinstance(b, Paragraph))
    assert not any(isinstance(block, Picture) for block in blocks)


def test_loose_timing_is_drawn(runs):
    assert any(isinstance(block, Picture) for block in TimingSection().blocks(runs[1:]))


def test_gaps_are_named(make_run):
    log = make_run()
    keep = [k for k in range(1001) if k not in (300, 301)]
    states = replace(log.joint_states, stamp=log.joint_states.stamp[keep], position=log.joint_states.position[keep])
    blocks = TimingSection().blocks([analyse(replace(log, joint_states=states))])
    assert any("joint_states 2 after 0.1495 s" in block.text for block in blocks if isinstance(block, Paragraph))


def test_runs_with_the_same_timing_share_their_rows(make_run):
    runs = [analyse(make_run(), label=name) for name in ("pd", "dae")]
    table = next(block for block in TimingSection().blocks(runs) if isinstance(block, TextTable))
    assert table.rows[0] == ("pd, dae",)
    assert table.rows[1][:3] == (
        "joint_states, joint_commands, joint_reference, tool_pose, tool_reference",
        "1001",
        "0",
    )
    assert len(table.rows) == 2


def test_torque_shares_of_several_runs_stand_in_a_table(runs):
    table = TorqueSection().blocks(runs)[0]
    assert isinstance(table, TextTable)
    assert table.rows[0] == ("one", "8.36", "3.00")


def test_provenance_shows_once_what_all_runs_have_in_common(runs):
    (common,) = [block for block in ProvenanceSection().blocks(runs) if isinstance(block, TextTable)]
    assert ("robot.model_hash", "0f3a9c") in common.rows


def test_provenance_of_runs_that_differ_has_a_row_for_each(make_run):
    runs = [analyse(make_run(label=name)) for name in ("circle_pd", "circle_dae")]
    tables = [block for block in ProvenanceSection().blocks(runs) if isinstance(block, TextTable)]
    assert tables[1].rows == (("circle_pd", "circle_pd"), ("circle_dae", "circle_dae"))


def test_warnings_of_the_log_reach_the_report(make_run):
    log = replace(make_run(), warnings=("tool_pose holds 3 messages that repeat a stamp",))
    blocks = ProvenanceSection().blocks([analyse(log)])
    assert blocks[0] == Paragraph("circle: tool_pose holds 3 messages that repeat a stamp.", "warning")
