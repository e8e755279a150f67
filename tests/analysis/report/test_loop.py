"""The report of loops."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from flexros.analysis.control_loops import control_loops
from flexros.analysis.report.loop import _drawn, common_beginning, loop_table, write_loop_report
from flexros.control.design.margins import LoopMargins
from flexros.control.design.methods.base import DesignProblem
from flexros.control.pid import Pid
from flexros.report.base import TextTable
from flexros.robot import load_robot


@pytest.mark.parametrize(
    ("labels", "beginning"),
    [(["a b 1 Nm", "a b 2 Nm"], "a b"), (["a b"], ""), (["a", "a"], ""), (["a b", "a b"], "a"), (["a 1", "b 1"], "")],
)
def test_words_that_all_plants_share_are_said_once(labels: list[str], beginning: str) -> None:
    assert common_beginning(labels) == beginning


def test_report_names_every_plant_and_the_margins(tmp_path: Path) -> None:
    robot = load_robot("four_mass")
    problem = DesignProblem.of(robot)
    file = tmp_path / "loops.html"
    write_loop_report({"C": control_loops(Pid(kp=24.0, ki=100.0, kd=2.35), problem)}, file, title="Loops")
    text = file.read_text()
    labels = problem.sampled.labels
    beginning = common_beginning(labels)
    assert beginning == "four_mass body_1.rz"
    assert f"plants: {beginning}" in text
    assert all(label.removeprefix(beginning).strip() in text for label in labels)
    for words in ("Bode", "Nyquist", "unit step", "Smallest margins"):
        assert words in text


@pytest.mark.parametrize(("motors", "upright"), [(2, True), (6, False)])
def test_table_of_few_loops_is_narrow_enough_for_a_phone(motors: int, upright: bool) -> None:
    one = LoopMargins("e12", 0, 0.99, 44.1, 0.0, 0.5, 0.0134, 16.7, 2.0, 2.19, 0.263, 5.05)
    (table,) = (
        block
        for block in loop_table([replace(one, motor=motor) for motor in range(motors)])
        if isinstance(block, TextTable)
    )
    assert (len(table.header) == 1 + motors) is upright
    names = table.header[1:] if upright else tuple(row[1] for row in table.rows)
    assert names == tuple(f"motor_{motor + 1}" for motor in range(motors))
    crossover = next(row for row in table.rows if row[0] == "Crossover [Hz]")[1] if upright else table.rows[0][6]
    assert crossover == "16.7"


def test_curves_are_smooth_at_a_resonance() -> None:
    frequency = np.geomspace(0.1, 100.0, 3000)
    loop = 1.0 / (1.0 - (frequency / 10.0) ** 2 + 0.02j * frequency / 10.0)
    points = _drawn(frequency, loop)
    assert points[0] == 0
    assert points[-1] == 2999
    assert len(points) < 1200
    inside = np.abs(loop[points]) < 3.0
    steps = np.abs(np.diff(loop[points]))[inside[1:] & inside[:-1]]
    assert steps.max() < 0.3
    assert np.diff(np.log10(frequency[points])).max() < 0.02
