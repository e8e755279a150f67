"""Command that runs campaigns: long computations whose pages of results are committed."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from flexros.atomic_file import write_result
from flexros.cli.output import print_json, say
from flexros.cli.progress import progress_bar
from flexros.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable

    from distributed import Client

    from flexros.validation.campaigns.base import CampaignResult

WORK = "campaign_work"
"""Default folder of finished parts, in the folder of the results."""


def campaign(
    name: list[str] = typer.Argument(None, help="Campaigns to run, e.g. coverage; default: all."),
    out: Path = typer.Option(..., "--out", help="Folder of the pages of results, e.g. docs/results."),
    repetitions: int = typer.Option(0, "--repetitions", help="Number of repetitions; default: that of each campaign."),
    work: Path = typer.Option(
        None, "--work", help="Folder of finished parts, from which a campaign continues; default: OUT/campaign_work."
    ),
    scheduler: str = typer.Option("", "--scheduler", help="Address of a Dask scheduler; default: in this process."),
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> None:
    """Run campaigns such as coverage, or what is left of them, and write their pages of results."""
    from flexros.scheduler import connected
    from flexros.validation.campaigns.base import campaign_named, campaigns

    chosen = [campaign_named(wanted, "the command line") for wanted in name or campaigns()]
    if repetitions < 0:
        raise InputError(f"--repetitions is {repetitions}, but must be 1 or more; leave it out for the usual number")
    _make(out)
    records = {}
    with connected(scheduler) as client:
        for each in chosen:
            folder = (work or out / WORK) / each.name
            _make(folder)
            if not as_json:
                say(f"{each.name}: {each.question}")
            result = _run(each.run, folder, client, repetitions)
            for file, text in result.files.items():
                _make((out / file).parent)
                write_result(out / file, text, f"result of campaign {each.name}")
            records[each.name] = dict(result.record)
            if not as_json:
                for sentence in result.summary:
                    say(sentence)
                say(f"Results: {', '.join(str(out / file) for file in result.files)}")
    if as_json:
        print_json(records)


def _run(run: Callable[[Any], CampaignResult], folder: Path, client: Client, repetitions: int) -> CampaignResult:
    """Run one campaign with a progress bar."""
    from flexros.validation.campaigns.base import CampaignRequest

    with progress_bar() as bar:
        tasks: dict[str, Any] = {}

        def report(what: str, done: int, whole: int) -> None:
            if what not in tasks:
                tasks[what] = bar.add_task(what, total=whole)
            bar.update(tasks[what], completed=done, total=whole)

        return run(CampaignRequest(folder, client, repetitions or None, report))


def _make(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"the folder '{folder}' cannot be made ({error.strerror or error}); give one that can be written"
        ) from error


COMMANDS: dict[str, Callable[..., Any]] = {"campaign": campaign}
HELP = ""
