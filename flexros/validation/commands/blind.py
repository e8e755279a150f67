"""Commands of the blind check: make logs with sealed truths, diagnose them, score the answers."""

from __future__ import annotations

import secrets
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from flexros.cli.output import console, print_json, say
from flexros.cli.progress import progress_bar
from flexros.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

SCHEDULER = "Address of a Dask scheduler; default: in this process."


def make(
    out: Path = typer.Option(..., "--out", help="Folder of the logs, one folder per case."),
    truth: Path = typer.Option(..., "--truth", help="Folder of the sealed truths; not inside the folder of the logs."),
    seed: int = typer.Option(..., "--seed", help="Seed of all that is drawn."),
    development: bool = typer.Option(False, "--development", help="Draw from the stream that development may look at."),
    cases: str = typer.Option("", "--cases", help="Part of the plan, FIRST:END, e.g. 0:200; default: all."),
    robots: str = typer.Option("", "--robots", help="Robots and their shares, e.g. four_mass=0.5,e12=0.5."),
    per_size: int = typer.Option(6, "--per-size", min=0, help="Cases per effect and size."),
    nulls: int = typer.Option(400, "--nulls", min=0, help="Cases without deviation."),
    unknowns: int = typer.Option(60, "--unknowns", min=0, help="Cases with a cause outside the library."),
    pairs: int = typer.Option(80, "--pairs", min=0, help="Cases with two effects."),
    crowds: int = typer.Option(0, "--crowds", min=0, help="Cases with 3 to 12 effects."),
    duration: float = typer.Option(40.0, "--duration", min=4.0, help="Length of a log to fit [s]; others have half."),
    scheduler: str = typer.Option("", "--scheduler", help=SCHEDULER),
) -> None:
    """Draw cases, write their logs, and seal their truths; existing cases are kept."""
    from flexros.random_streams import Stream
    from flexros.validation.blind.make_case import MakeSettings, make_case
    from flexros.validation.blind.plan import PlanSettings, plan_cases

    if out.resolve() == truth.resolve() or out.resolve() in truth.resolve().parents:
        raise InputError(f"--truth is '{truth}', which is in the folder of the logs '{out}'; give one apart from it")
    if seed < 0:
        raise InputError(f"--seed is {seed}, allowed are 0 and above; give another one")
    stream = Stream.BLIND_DEVELOPMENT if development else Stream.BLIND_EVALUATION
    plan = PlanSettings(per_size=per_size, nulls=nulls, unknowns=unknowns, pairs=pairs, crowds=crowds)
    if robots:
        shares = _shares(robots)
        plan = replace(plan, robots=shares, crowd_robots=shares)
    chosen = part_of(plan_cases(plan, seed, stream), cases)
    lengths = (duration, duration / 2, duration / 2)
    settings = MakeSettings(seed, stream, lengths, secrets.token_hex(16))
    out.mkdir(parents=True, exist_ok=True)
    _work(scheduler, make_case, [(case, settings, out, truth) for case in chosen], "cases made")
    say(f"{len(chosen)} cases in {out}, their truths in {truth}; go on with: flexros blind run {out}")


def run(
    logs: Path = typer.Argument(help="Folder of the logs that `flexros blind make` wrote."),
    cases: str = typer.Option("", "--cases", help="Part of the cases, FIRST:END, e.g. 0:50; default: all."),
    keep_logs: bool = typer.Option(
        True, "--keep-logs/--no-keep-logs", help="Keep the logs of a case once it is diagnosed."
    ),
    scheduler: str = typer.Option("", "--scheduler", help=SCHEDULER),
) -> None:
    """Diagnose cases from logs and nominal models alone; those that are diagnosed already are kept."""
    from flexros.validation.blind.diagnose_case import case_folders, diagnose_case, failures, waiting

    wanted = set(part_of(case_folders(logs), cases))
    folders = [folder for folder in waiting(logs) if folder in wanted]
    _work(scheduler, diagnose_case, [(folder, keep_logs) for folder in folders], "cases diagnosed")
    say(f"{len(folders)} cases diagnosed, {len(waiting(logs))} of {len(case_folders(logs))} are left in {logs}")
    for name, reason in failures(logs).items():
        say(f"{name}: {reason} (remove its failure.txt to try again)")


def score(
    logs: Path = typer.Argument(help="Folder of the logs and their diagnoses."),
    truth: Path = typer.Option(..., "--truth", help="Folder of the sealed truths."),
    oracle: bool = typer.Option(
        False, "--oracle", help="Fit the true effect, and try the patches on third logs, where the logs were kept."
    ),
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> None:
    """Open the truths of all cases that were diagnosed, check their seals, and count."""
    from flexros.validation.blind.score.crowd_tables import crowd_table
    from flexros.validation.blind.score.crowds import crowds_of
    from flexros.validation.blind.score.score import read_answers, record
    from flexros.validation.blind.score.tables import score_table, wrong_table

    answers = read_answers(logs, truth, oracle)
    if as_json:
        print_json(record(answers))
        return
    crowds = crowds_of(answers)
    if crowds:
        console.print(crowd_table(crowds))
    if len(crowds) < len(answers):
        others = [one for one in answers if one not in crowds]
        console.print(score_table(others, console.width))
        console.print(wrong_table(others))


def part_of(items: Sequence[Any], text: str) -> list[Any]:
    """Take a part of a list.

    Args:
        items: The list.
        text: FIRST:END as in Python, both not negative; empty for all.

    Raises:
        InputError: Another form, or a part that holds nothing.
    """
    if not text:
        return list(items)
    first, colon, end = text.partition(":")
    if not colon or not all(part.isdigit() or not part for part in (first, end)):
        raise InputError(f"--cases is '{text}', but must be FIRST:END, for instance 0:200")
    part = list(items[int(first or 0) : int(end) if end else len(items)])
    if not part:
        raise InputError(f"--cases is '{text}', which holds none of the {len(items)} cases; give another part")
    return part


def _shares(text: str) -> dict[str, float]:
    """Read robots and their shares."""
    shares = {}
    for part in text.split(","):
        name, _, value = part.partition("=")
        try:
            shares[name.strip()] = float(value or 1.0)
        except ValueError:
            raise InputError(f"--robots is '{text}', but must be NAME=SHARE,..., for instance four_mass=1") from None
        if not shares[name.strip()] > 0:
            raise InputError(f"--robots gives {name} the share {value}, but must be above 0; leave the robot out")
    return shares


def _work(scheduler: str, function: Callable[..., None], jobs: list[tuple[Any, ...]], what: str) -> None:
    """Work through jobs with a progress bar."""
    from flexros.scheduler import connected
    from flexros.validation.blind.diagnose_case import on_workers

    if not jobs:
        return
    with connected(scheduler) as client, progress_bar() as bar:
        task = bar.add_task(what, total=len(jobs))
        on_workers(client, function, jobs, lambda done: bar.update(task, completed=done))


COMMANDS: dict[str, Callable[..., Any]] = {"make": make, "run": run, "score": score}
"""Subcommands of `flexros blind`, by name."""

HELP = "Check the diagnosis blindly: logs with hidden deviations, diagnosed without their truth, then scored."
