"""Command that plans the time-optimal motion along the path of a scenario."""

from __future__ import annotations

import typer
from rich.table import Table

from flexros.cli.model import ROBOT
from flexros.cli.output import console, print_json, say
from flexros.cli.progress import working


def fastest(
    scenario: str = typer.Argument(help="Scenario with a path: built-in name or YAML."),
    setting: list[str] = typer.Option(
        [], "--set", help="Change a key of the scenario, e.g. trajectory.time_law.smoothing=0.05."
    ),
    model: str = typer.Option("", "--model", help=f"{ROBOT} Default: that of the scenario."),
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> None:
    """Time-optimal motion on the path of a scenario within torque and speed limits, and which limit decides where."""
    from flexros.cli.commands.run import changed_scenario
    from flexros.scenario.motion import fastest_moves

    changed = changed_scenario(scenario, model, setting)
    with working("planning"):
        moves = fastest_moves(changed)
    if as_json:
        print_json([move.summary() for move in moves])
        return
    table = Table(
        "move", "rigid arm [s]", "smooth [s]", "smoothing [s]", "at its limit, share of the time of the rigid arm"
    )
    for number, move in enumerate(moves, start=1):
        shares = ", ".join(f"{name} {100 * share:.0f} %" for name, share in move.limiting().items() if share > 0.005)
        table.add_row(str(number), f"{move.least_duration:.4f}", f"{move.duration:.4f}", f"{move.smoothing:g}", shares)
    console.print(table)
    say("Rigid arm: the bound with jumps of the acceleration. Smooth: what a run with this time law does.")
