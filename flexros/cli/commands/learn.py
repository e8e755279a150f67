"""Command that repeats a scenario and learns from its tool error."""

from __future__ import annotations

from pathlib import Path

import typer
from rich.table import Table

from flexros.cli.output import console, print_json, say
from flexros.cli.progress import progress_bar


def learn(
    scenario: str = typer.Argument(help="Scenario with a path of tool positions: built-in name or YAML."),
    trials: int = typer.Option(8, "--trials", help="Number of runs, the first without a correction."),
    gain: float = typer.Option(0.8, "--gain", help="Share of the error that a run corrects [1]."),
    bandwidth: float = typer.Option(50.0, "--bandwidth", help="Cut-off of the low-pass of the correction [Hz]."),
    setting: list[str] = typer.Option([], "--set", help="Change a key of the scenario, e.g. noise=false."),
    model: str = typer.Option("", "--model", help="Robot instead of the scenario's."),
    out: Path = typer.Option(None, "--out", help="Folder of the log of the last run."),
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> None:
    """Iterative learning control: repeat a scenario, correct its references by the tool error of the run before."""
    from dataclasses import replace

    from flexros.cli.commands.run import changed_scenario
    from flexros.logs.write_log import write_log
    from flexros.scenario.experiment import Experiment
    from flexros.scenario.learning import LearningSettings
    from flexros.scenario.learning import learn as repeat

    experiment = Experiment.prepare(changed_scenario(scenario, model, setting))
    with progress_bar() as bar:
        task = bar.add_task("runs", total=trials)
        settings = LearningSettings(trials, gain, bandwidth)
        result = repeat(experiment, settings, lambda done: bar.update(task, completed=done))
    if out is not None:
        write_log(replace(result.log, provenance=experiment.provenance()), out)
    if as_json:
        print_json({"max_mm": (1e3 * result.largest).tolist(), "rms_mm": (1e3 * result.rms).tolist()})
        return
    table = Table("run", "largest error [mm]", "rms [mm]")
    for number, (largest, rms) in enumerate(zip(result.largest, result.rms, strict=True), start=1):
        table.add_row(str(number), f"{1e3 * largest:.4f}", f"{1e3 * rms:.4f}")
    console.print(table)
    if out is not None:
        say(f"Log of the last run: {out}")
