from __future__ import annotations

import pytest

from flexros.analysis import analyse
from flexros.analysis.figures_table import figure_rows


def test_rows_equal_the_analysis(make_run):
    analysis = analyse(make_run(cycles=2))
    rows = {(row.group, row.name): row.values[0] for row in figure_rows([analysis])}
    assert float(rows["Path", "path error, max"]) == pytest.approx(1e3 * analysis.path.path.maximum, rel=1e-3)
    assert float(rows["ISO 9283", "path repeatability RT_p"]) == pytest.approx(
        1e3 * analysis.performance.position_repeatability, rel=1e-3
    )
    assert float(rows["motor_1", "feedback share of torque"]) == pytest.approx(
        1e2 * analysis.motors[0].feedback_share, rel=1e-3
    )
    assert rows["Timing", "joint_states, samples"] == str(analysis.timing.topics[0].count)


def test_a_figure_that_one_run_lacks_is_marked(make_run):
    rows = figure_rows([analyse(make_run()), analyse(make_run(cycles=2))])
    values = {row.name: row.values for row in rows}
    assert values["path repeatability RT_p"][0] == "-"
    assert values["path repeatability RT_p"][1] != "-"


def test_each_group_is_contiguous(make_run):
    groups = [row.group for row in figure_rows([analyse(make_run()), analyse(make_run(cycles=2))])]
    assert groups == sorted(groups, key=groups.index)
