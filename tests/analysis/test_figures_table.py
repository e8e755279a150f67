from __future__ import annotations

import io

import numpy as np
import pytest
from rich.console import Console

from flexros.analysis import analyse
from flexros.analysis.figures_table import figure_rows, terminal_table
from flexros.report.number_text import number, percent


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (None, "-"),
        (float("nan"), "-"),
        (0.0, "0"),
        (1001.0, "1001"),
        (0.284912, "0.2849"),
        (12.8, "12.80"),
        (3.2e-6, "3.200e-06"),
        (-0.05, "-0.05000"),
        (12345.6, "12346"),
    ],
)
def test_numbers_are_written_with_four_digits(value, text):
    assert number(value) == text


def test_percent_is_cut_where_it_means_nothing():
    assert percent(0.0213) == "2.13"
    assert percent(12.0) == ">1000"
    assert percent(np.inf) == ">1000"
    assert percent(np.nan) == ">1000"


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


def test_each_group_stands_together(make_run):
    groups = [row.group for row in figure_rows([analyse(make_run()), analyse(make_run(cycles=2))])]
    assert groups == sorted(groups, key=groups.index)


def test_terminal_table_prints_the_figures(make_run):
    analysis = analyse(make_run(), label="circle_dae")
    console = Console(file=io.StringIO(), width=100)
    console.print(terminal_table([analysis]))
    text = console.file.getvalue()
    assert "circle_dae" in text
    assert number(1e3 * analysis.path.path.maximum) in text


@pytest.mark.parametrize("label", ["[red]x", "[/b]", "a[b]c"])
def test_a_label_with_brackets_is_printed_as_it_is(make_run, label):
    console = Console(file=io.StringIO(), width=100)
    console.print(terminal_table([analyse(make_run(), label=label)]))
    assert console.file.getvalue().splitlines()[0].split() == ["figure", "unit", label]


@pytest.mark.parametrize("width", [40, 60, 80])
def test_no_figure_is_cut_in_a_narrow_terminal(make_run, width):
    runs = [analyse(make_run(), label="first"), analyse(make_run(2e-4), label="circle_dae2_load_210kg")]
    console = Console(file=io.StringIO(), width=width)
    console.print(terminal_table(runs))
    printed = console.file.getvalue()
    assert "…" not in printed
    words = printed.split()
    assert all(value in words for row in figure_rows(runs) for value in row.values)
    assert all(len(line) <= width for line in printed.splitlines())
