from __future__ import annotations

import io

import pytest
from rich.console import Console

from flexros.analysis import analyse
from flexros.analysis.comparison import Comparison, MethodRun
from flexros.analysis.figures_table import figure_rows
from flexros.analysis.terminal_tables import comparison_table, terminal_table
from flexros.report.number_text import number


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


def test_comparison_prints_published_reading_and_run(comparison):
    console = Console(file=io.StringIO(), width=120)
    console.print(comparison_table(comparison))
    line = next(line for line in console.file.getvalue().splitlines() if line.startswith("DAE"))
    attained = comparison.rows()[0].texts()[4]
    assert line.split()[:5] == ["DAE", "nominal", "0.320", "0.329", attained]


def test_brackets_in_the_names_of_a_comparison_are_printed_as_they_are(make_run):
    run = MethodRun("[bold]DAE[/b]", "load [x]", analyse(make_run()))
    console = Console(file=io.StringIO(), width=140)
    console.print(comparison_table(Comparison((run,))))
    printed = console.file.getvalue()
    assert "published [mm]" in printed
    assert "[bold]DAE[/b]  load [x]" in printed


def test_no_figure_of_a_comparison_is_cut_in_a_narrow_terminal(comparison):
    console = Console(file=io.StringIO(), width=60)
    console.print(comparison_table(comparison))
    printed = console.file.getvalue()
    assert "…" not in printed
    assert all(text in printed for row in comparison.rows() for text in row.texts())
    assert all(len(line) <= 60 for line in printed.splitlines())
