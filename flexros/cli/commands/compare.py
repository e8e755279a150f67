"""Command that puts several diagnoses side by side."""

from __future__ import annotations

from pathlib import Path

import typer

from flexros.cli.output import console, print_json, say
from flexros.cli.progress import working


def compare(
    diagnosis: list[Path] = typer.Argument(help="Folders that `flexros diagnose` wrote, at least two."),
    report: Path = typer.Option(None, "--report", help="Write an HTML page that opens offline."),
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> None:
    """Compare diagnoses: verdicts, effects, parameters of the model, and which differ beyond their deviations."""
    from flexros.gap.report.compared import sentence, terminal_tables, write_compared
    from flexros.gap.report.comparison import read_comparison

    with working("comparing"):
        compared = read_comparison(diagnosis)
        if report:
            write_compared(compared, report)
    if as_json:
        print_json(
            {
                "diagnoses": [
                    {
                        "name": name,
                        "log": str(one.provenance.get("log", "")),
                        "robot": str(one.provenance.get("robot", "")),
                        "verdict": one.verdict,
                        "gap": one.gap.model_dump(mode="json"),
                    }
                    for name, one in zip(compared.names, compared.diagnoses, strict=True)
                ],
                **{
                    key: [{**vars(row), "p_same": row.p_same} for row in rows]
                    for key, rows in (("effects", compared.effects), ("numbers", compared.numbers))
                },
            }
        )
        return
    console.print(sentence(compared))
    for table in terminal_tables(compared):
        console.print(table)
    if report:
        say(f"report: {report}")
