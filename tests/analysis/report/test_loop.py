"""The report of loops."""

from __future__ import annotations

from pathlib import Path

from flexros.analysis.report.loop import write_loop_report
from flexros.control.context import LoopContext
from flexros.control.design.margins import loop_margins
from flexros.control.design.methods.base import DesignProblem
from flexros.control.linear_controller import linear_controller
from flexros.control.pid import Pid
from flexros.robot import load_robot


def test_report_names_every_plant_and_the_margins(tmp_path: Path) -> None:
    robot = load_robot("four_mass")
    problem = DesignProblem.of(robot)
    linear = linear_controller(Pid(kp=24.0, ki=100.0, kd=2.35), LoopContext(robot, robot.sample_time))
    margins = loop_margins(problem.sampled, linear)
    file = tmp_path / "loops.html"
    write_loop_report(problem.sampled, {"C": linear}, {"C": margins}, file, title="Loops")
    text = file.read_text()
    assert all(label in text for label in problem.sampled.labels)
    for words in ("Bode", "Nyquist", "unit step", "Smallest margins"):
        assert words in text
