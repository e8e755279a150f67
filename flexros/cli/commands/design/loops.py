"""Margins of the loops of a controller, for people and as JSON."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from rich.table import Table

from flexros.cli.output import console, print_json, say

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from flexros.control.base import AbstractControlLaw
    from flexros.control.design.margins import LoopMargins
    from flexros.control.design.methods.base import DesignProblem


def show_loops(
    laws: Mapping[str, AbstractControlLaw],
    problem: DesignProblem,
    figures: Mapping[str, float],
    report: Path | None,
    as_json: bool,
    title: str,
) -> None:
    """Print the margins of the loops, and write the report.

    Args:
        laws: Control laws by name.
        problem: Robot, poses and further plants.
        figures: Figures of the design by name.
        report: File of the report; None for none.
        as_json: Whether JSON is printed.
        title: Title of the report.
    """
    from flexros.analysis.control_loops import control_loops

    loops = {key: control_loops(law, problem) for key, law in laws.items()}
    if report:
        from flexros.analysis.report.loop import write_loop_report

        write_loop_report(loops, report, title=title)
    if as_json:
        print_json(
            {
                "figures": figures,
                "controllers": {
                    key: {
                        "order": len(of_law[0].controller.state_step),
                        "margins": [entry.as_dict() for loop in of_law for entry in loop.margins],
                    }
                    for key, of_law in loops.items()
                },
            }
        )
        return
    for name, value in figures.items():
        say(f"{name}: {value:.4g}")
    for key, of_law in loops.items():
        entries = [entry for loop in of_law for entry in loop.margins]
        console.print(_margin_table(key if len(loops) > 1 else "plant", entries))
    if report:
        say(f"report: {report}")


def _margin_table(heading: str, entries: Sequence[LoopMargins]) -> Table:
    table = Table(heading, "motor", "eigenvalue", "gain margin", "phase [deg]", "delay [ms]", "max |S|", "settling [s]")
    for entry in entries:
        table.add_row(
            entry.plant,
            str(entry.motor + 1),
            f"{entry.largest_eigenvalue:.5f}",
            f"{entry.gain_down:.2g}-{entry.gain_up:.3g}",
            f"{np.degrees(entry.phase):.1f}",
            f"{1e3 * entry.delay:.2f}",
            f"{entry.sensitivity:.3g}",
            f"{entry.settling:.3g}",
        )
    return table
