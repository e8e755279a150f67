"""End of the demonstration: the budget of a machine that others measured."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from flexros.cli.output import console, say

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.gap.result import DiagnosisResult

RECORDED = Path(__file__).parents[2] / "scenario" / "measured" / "double_pendulum"
"""Logs, mapping, robot file and licence of the machine."""
OWNER = "DFKI RIC Underactuated Robotics Lab, BSD 3-Clause, github.com/dfki-ric-underactuated-lab/double_pendulum"
"""Whose data it is."""


@dataclass(frozen=True, eq=False)
class Budgeted:
    """A measured machine, diagnosed.

    Attributes:
        result: The diagnosis.
        folder: Folder of its files.
    """

    result: DiagnosisResult
    folder: Path

    def as_dict(self) -> dict[str, Any]:
        """Return the figures for JSON."""
        diagnosis = self.result.diagnosis.model_dump(mode="json", by_alias=True)
        kept = ("verdict", "causes", "gap", "budget", "waterfall", "unexplained", "model_numbers")
        return {"data": OWNER, **{key: diagnosis[key] for key in kept}}


def budgeted(folder: Path, progress: Callable[[str, float], None]) -> Budgeted:
    """Import two logs of the machine, diagnose one and check the answer on the other.

    Args:
        folder: Folder for logs and files of the diagnosis.
        progress: Called with the current step and the share of all that is done.
    """
    from flexros.effects.patching.patched_robot import load_model
    from flexros.gap.checked_log import checked_log
    from flexros.gap.diagnose import diagnose
    from flexros.gap.report.files import write_diagnosis
    from flexros.logs.foreign.import_log import import_log
    from flexros.logs.foreign.mapping import load_mapping
    from flexros.logs.write_log import write_log

    progress("measured machine", 0.0)
    model, mapping = str(RECORDED / "robot.yaml"), load_mapping(RECORDED / "mapping.yaml")
    known = load_model(model)
    logs = {name: import_log(mapping, [RECORDED / f"{name}.csv"]) for name in ("fit", "check")}
    for name, log in logs.items():
        write_log(log, folder / f"double_pendulum_{name}")
    fitted, held = (checked_log(log, known.robot, name=name) for name, log in logs.items())
    result = diagnose(fitted, known, holdout=held, log=logs["check"], progress=progress)
    write_diagnosis(result, model, folder / "double_pendulum")
    return Budgeted(result, folder / "double_pendulum")


def print_budget(measured: Budgeted) -> None:
    """Print whose machine it is, which effects make up its gap at each joint, and what is left."""
    from flexros.gap.report import terminal

    diagnosis = measured.result.diagnosis
    console.print()
    say("A measured machine: double pendulum with two quasi-direct drives, model without friction")
    say(f"  data: {OWNER}")
    console.print(terminal.verdict_line(diagnosis))
    for heading, lines in (
        ("Budget of its gap, in shares of it:", terminal.budget_lines(diagnosis)),
        ("Left unexplained, in shares of the gap:", terminal.rest_lines(diagnosis)),
    ):
        console.print(heading)
        for line in lines:
            say(f"  {line}")
    say(f"Report: {measured.folder / 'report.html'}")
