"""Last part of the demonstration: a hidden effect is diagnosed from a log, and the feedforward repaired with it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import typer
from rich.table import Table

from flexros.cli.output import console, say
from flexros.scenario import transports

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from flexros.analysis import Analysis
    from flexros.gap.schema import Diagnosis
    from flexros.scenario.scenario import Scenario

HIDDEN = "hidden_effect"
"""Built-in scenario whose plant has an effect that the model lacks."""

EXPERIMENT = "diagnosis"
"""Built-in scenario that excites the effects of a robot."""

REPORT = "repair.html"
"""Report of the runs before and after."""

LENGTH = 10.0
"""Length of the diagnosis experiment [s]: short, for a demonstration."""


@dataclass(frozen=True)
class Repair:
    """A diagnosis, and the path errors before and after the repair.

    Attributes:
        diagnosis: The answer.
        patch: The repaired model; None where nothing was found.
        ideal: The run of the robot without the effect.
        before: The run with the effect and the nominal model.
        after: The run with the effect and the repaired model; None where nothing was found.
    """

    diagnosis: Diagnosis
    patch: Path | None
    ideal: Analysis
    before: Analysis
    after: Analysis | None

    @property
    def runs(self) -> list[Analysis]:
        """All runs, in order."""
        return [run for run in (self.before, self.after, self.ideal) if run is not None]

    def as_dict(self) -> dict[str, Any]:
        """Return the figures for JSON."""
        return {
            "verdict": self.diagnosis.verdict,
            "causes": [cause.model_dump(mode="json") for cause in self.diagnosis.causes],
            "patch": None if self.patch is None else str(self.patch),
            "path_error_without_effect_m": _worst(self.ideal),
            "path_error_before_m": _worst(self.before),
            "path_error_after_m": None if self.after is None else _worst(self.after),
        }


def repair(folder: Path, transport: str, progress: Callable[[str, float], None]) -> Repair:
    """Run with a hidden effect, record an experiment, diagnose it, and run again with the repaired feedforward.

    Args:
        folder: Folder for logs and files of the diagnosis.
        transport: "ros" or "direct".
        progress: Called with the current step and the share of all that is done.

    Raises:
        RunError: A run aborted.
    """
    from flexros.scenario.scenario import load_scenario

    hidden = load_scenario(HIDDEN)
    progress("hidden effect", 0.0)
    without = hidden.with_values({"plant.effects": []}, "demo, without effect")
    ideal = _analysed(without, folder / "without_effect", transport, "without hidden effect")
    before = _analysed(hidden, folder / HIDDEN, transport, "hidden effect, nominal model")
    progress("experiment", 0.1)
    shown = {"robot": hidden.robot, "plant.effects": list(hidden.plant.effects), "diagnosis.length": LENGTH}
    log = folder / "diagnosis_log"
    _run(load_scenario(EXPERIMENT).with_values(shown, "demo, diagnosis"), log, transport)
    diagnosis, patch = _diagnosed(log, hidden.robot, folder / "diagnosis", progress)
    after = None
    if patch is not None:
        progress("repaired", 0.95)
        repaired = hidden.with_values({"feedforward_model": str(patch)}, "demo, repaired")
        after = _analysed(repaired, folder / f"{HIDDEN}_repaired", transport, "hidden effect, repaired model")
    return Repair(diagnosis, patch, ideal, before, after)


def print_repair(repair: Repair, folder: Path) -> None:
    """Print the verdict, the path errors and the files of a repair."""
    from flexros.gap.report.terminal import verdict_line

    console.print()
    say(f"Closing the loop: {verdict_line(repair.diagnosis)}")
    table = Table("run", "largest path error [mm]", title="A hidden effect, diagnosed and repaired")
    for run in repair.runs:
        table.add_row(run.label, f"{1e3 * _worst(run):.3f}")
    console.print(table)
    if repair.patch is None:
        typer.echo("flexros: the diagnosis found no effect to repair the model with", err=True)
    else:
        say(f"Patch: {repair.patch}; open {folder / 'diagnosis' / 'report.html'} and {folder / REPORT}")


def _diagnosed(
    log: Path, model: str, folder: Path, progress: Callable[[str, float], None]
) -> tuple[Diagnosis, Path | None]:
    """Diagnose a log against the nominal model; write its files."""
    from flexros.effects.patching.patched_robot import load_model
    from flexros.gap.checked_log import checked_log
    from flexros.gap.diagnose import diagnose
    from flexros.gap.report.files import PATCH, write_diagnosis
    from flexros.logs.reader import read_log

    known = load_model(model)
    recorded = read_log(log)
    record = checked_log(recorded, known.robot, name=log.name)
    result = diagnose(record, known, log=recorded, progress=lambda stage, share: progress(stage, 0.15 + 0.8 * share))
    files = write_diagnosis(result, model, folder)
    return result.diagnosis, folder / PATCH if PATCH in files else None


def _run(scenario: Scenario, bag: Path, transport: str) -> None:
    run = transports.run_direct(scenario, bag) if transport == "direct" else transports.run_ros(scenario, bag)
    run.require_complete(bag.name)


def _analysed(scenario: Scenario, bag: Path, transport: str, label: str) -> Analysis:
    from flexros.analysis import analyse
    from flexros.logs.reader import read_log
    from flexros.robot import load_robot

    _run(scenario, bag, transport)
    return analyse(read_log(bag), robot=load_robot(scenario.robot), label=label)


def _worst(analysis: Analysis) -> float:
    """Largest path error [m]."""
    assert analysis.path is not None
    return analysis.path.path.maximum
