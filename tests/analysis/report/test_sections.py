"""Laws of all sections of the report, and the content of single ones."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.analysis import analyse
from flexros.analysis.report.frequency_responses import FrequencyResponseSection
from flexros.analysis.report.provenance import ProvenanceSection
from flexros.analysis.report.summary import SummarySection, verdict
from flexros.analysis.report.timing import TimingSection
from flexros.analysis.report.torques import TorqueSection
from flexros.analysis.report.write import RUN_SECTIONS
from flexros.report.base import Folded, Paragraph, Picture, TextTable

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def runs(make_run):
    return [analyse(make_run(), label="one"), analyse(make_run(cycles=3, jitter=2e-5), label="three")]


@pytest.fixture(scope="module")
def experiment(experiment_log):
    return analyse(experiment_log, label="experiment")


@pytest.mark.parametrize("section", RUN_SECTIONS, ids=lambda section: type(section).__name__)
def test_every_section_shows_one_run_and_several(section, runs, experiment):
    of_its_kind = [experiment, experiment] if isinstance(section, FrequencyResponseSection) else runs
    assert section.blocks(of_its_kind[:1])
    assert section.blocks(of_its_kind)


@pytest.mark.parametrize("section", RUN_SECTIONS, ids=lambda section: type(section).__name__)
def test_every_section_bears_a_log_of_positions_alone(section, make_run):
    full = make_run()
    bare = replace(full, joint_reference=None, joint_commands=None, tool_pose=None, tool_reference=None, provenance={})
    for block in section.blocks([analyse(bare)]):
        assert not isinstance(block, Picture)


@pytest.mark.parametrize("section", RUN_SECTIONS, ids=lambda section: type(section).__name__)
def test_every_picture_names_the_unit_of_every_titled_axis(section, runs, experiment):
    for block in section.blocks([*runs, experiment]):
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


def test_exact_timing_is_reported_as_exact_by_construction(runs):
    blocks = TimingSection().blocks(runs[:1])
    assert "exact by construction" in next(b.text for b in blocks if isinstance(b, Paragraph))
    assert not any(isinstance(block, Picture) for block in blocks)


def paced(log, received=True, **figures):
    """A run in real time: every tenth measurement is received 0.1 ms late, one 3 ms, which holds those behind it up."""
    late = np.where(np.arange(len(log.joint_states.stamp)) % 10 == 0, 100_000, 0)
    late[500] = 3_000_000
    if received:
        log = replace(
            log, joint_states=replace(log.joint_states, received=np.maximum.accumulate(log.joint_states.stamp + late))
        )
    return replace(log, plant_figures=figures, provenance={**log.provenance, "real_time": True})


KEPT = {
    "cycles": 1001,
    "period_p50_us": 500,
    "lateness_max_us": 1020,
    "late_percent": 3.5,
    "missed_commands": 1,
}


def texts(section, *runs):
    return [block.text for block in section.blocks(runs) if isinstance(block, Paragraph)]


def test_real_time_is_said_with_what_plant_and_recorder_saw(make_run):
    assert texts(TimingSection(), analyse(paced(make_run(), **KEPT))) == [
        "The loop ran in real time, paced by the wall clock: 3.50 % of 1001 cycles began more than a tenth of the "
        "sample time late (at most 1.02 ms), and 1 command was missed, for which the last one was held. The recorder "
        "received joint_states every 0.5000 ms (median); 99 % of the periods were below 0.6000 ms, the longest was "
        "3.500 ms."
    ]


@pytest.mark.parametrize(
    ("figures", "expected"),
    [
        ({}, "paced by the wall clock: the log does not contain the plant's report of it. "),
        ({"cycles": 9}, "paced by the wall clock: the plant did not report how well. "),
        ({"late_percent": 2.0, "missed_commands": 0}, "2 % of its cycles began more than a tenth of the sample time"),
        ({"late_percent": 2.0, "missed_commands": 0}, "late, and no command was missed. "),
        ({"missed_commands": 7}, "wall clock: 7 commands were missed, for which the last one was held. "),
    ],
)
def test_what_the_plant_did_not_report_is_left_open(make_run, figures, expected):
    (text,) = texts(TimingSection(), analyse(paced(make_run(), received=False, **figures)))
    assert expected in text
    assert text.endswith("The log times are the stamps, so the receive times are not known.")


def test_a_recorder_that_takes_messages_in_bursts_is_distinguished_from_the_loop(make_run):
    log = paced(make_run(), **KEPT)
    stamp = log.joint_states.stamp
    bursts = stamp[np.minimum((np.arange(1001) // 8 + 1) * 8, 1000)] + np.arange(1001) % 8 * 20_000
    log = replace(log, joint_states=replace(log.joint_states, received=bursts))
    (text,) = texts(TimingSection(), analyse(log))
    assert "The recorder received joint_states in bursts, after waits of up to 3.860 ms" in text


def unfolded(blocks):
    """The blocks, with those that are folded in their place."""
    return [inner for block in blocks for inner in (block.blocks if isinstance(block, Folded) else (block,))]


def test_real_time_is_tabled_and_drawn_by_the_times_of_receipt(make_run):
    blocks = TimingSection().blocks([analyse(paced(make_run(), **KEPT))])
    by_stamps, received, schedule = (block for block in blocks if isinstance(block, TextTable))
    assert by_stamps.caption.endswith("are the planned instants: they show loss, but no jitter.")
    assert received.rows[0][:5] == ("joint_states", "1001", "0.5000", "0.5000", "0.6000")
    assert schedule.rows == (("plant", "1001", "0.5000", "-", "-", "-", "1020", "3.50", "1"),)
    (picture,) = (block for block in blocks if isinstance(block, Picture))
    periods, bars = picture.figure.data
    assert max(periods.y) == pytest.approx(3.5)
    assert sum(bars.y) == 1000
    assert max(bars.x) < 1.5, "what is far longer counts in the last bar"
    assert bars.y[-1] == 1


def test_runs_of_both_kinds_are_distinguished(make_run):
    runs = [analyse(make_run(), label="still"), analyse(paced(make_run(), **KEPT), label="paced")]
    first, second = texts(TimingSection(), *runs)
    assert first.startswith("In still all stamps are on an exact grid")
    assert "In lock-step" in first
    assert second.startswith("paced ran in real time")


def test_a_log_without_a_mode_is_not_called_lock_step(make_run):
    (text,) = texts(TimingSection(), analyse(replace(make_run(), provenance={})))
    assert text.endswith("Whether the loop ran in real time or in lock-step is not known.")


def test_verdict_states_the_pace_of_real_time(make_run):
    run = analyse(paced(make_run(), **KEPT))
    assert verdict([run]).endswith(
        "No sample is missing. In real time 3.50 % of the cycles began late and 1 command was missed, for which the "
        "last one was held."
    )
    other = analyse(paced(make_run(), **{**KEPT, "late_percent": 1.0, "missed_commands": 0}), label="other")
    assert "In real time at most 3.50 % of the cycles began late and 1 command was missed" in verdict([run, other])


@pytest.mark.parametrize(
    ("figures", "received", "tile"),
    [
        (KEPT, True, ("Loop period, median", "0.5000", "ms", "late 3.50 %, missed 1")),
        ({}, True, ("Loop period, received", "0.5000", "ms", "jitter std 112 µs")),
        ({}, False, ("Loop period, mean", "0.5000", "ms", "by the stamps")),
    ],
)
def test_the_period_of_the_loop_is_that_of_the_plant_where_it_is_known(make_run, figures, received, tile):
    tiles = SummarySection().blocks([analyse(paced(make_run(), received=received, **figures))])[1]
    assert tiles.items[-1] == tile


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
    table = next(block for block in unfolded(TimingSection().blocks(runs)) if isinstance(block, TextTable))
    assert table.rows[0] == ("pd, dae",)
    assert table.rows[1][:3] == (
        "joint_states, joint_commands, joint_reference, tool_pose, tool_reference",
        "1001",
        "0",
    )
    assert len(table.rows) == 2
    assert table.caption.endswith("jitter is without the gaps.")


def test_the_torque_limit_is_named_with_the_share_of_the_run(make_run):
    log = make_run()
    provenance = {**log.provenance, "scenario": {"controller": {"torque_limit": 2000.0}}}
    effort = np.clip(log.joint_commands.effort, -2000.0, 2000.0)
    log = replace(log, joint_commands=replace(log.joint_commands, effort=effort), provenance=provenance)
    share = 100.0 * np.mean(np.abs(effort[:, 1]) == 2000.0)
    (text,) = texts(TorqueSection(), analyse(log))
    assert text.endswith(f"; the torque limit was reached at motor_2 (for {share:.1f} % of the run).")


def test_torque_shares_of_several_runs_are_in_a_table(runs):
    table = TorqueSection().blocks(runs)[0]
    assert isinstance(table, TextTable)
    assert table.rows[0] == ("one", "8.36", "3.00")


def test_provenance_shows_once_what_all_runs_have_in_common(runs):
    (common,) = [block for block in unfolded(ProvenanceSection().blocks(runs)) if isinstance(block, TextTable)]
    assert ("model_hash", "0f3a9c") in common.rows[common.rows.index(("robot",)) :]


def test_provenance_of_runs_that_differ_has_a_row_for_each(make_run):
    runs = [analyse(make_run(label=name)) for name in ("circle_pd", "circle_dae")]
    tables = [block for block in unfolded(ProvenanceSection().blocks(runs)) if isinstance(block, TextTable)]
    assert tables[0].rows[1:] == (("circle_pd", "circle_pd"), ("circle_dae", "circle_dae"))


def test_warnings_of_the_log_reach_the_report(make_run):
    log = replace(make_run(), warnings=("tool_pose holds 3 messages that repeat a stamp",))
    blocks = ProvenanceSection().blocks([analyse(log)])
    assert blocks[0] == Paragraph("circle: tool_pose holds 3 messages that repeat a stamp.", "warning")
