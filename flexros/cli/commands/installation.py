"""Commands about the installation: its health, and what it leaves on the disk."""

from __future__ import annotations

import os
import sys
from typing import TYPE_CHECKING

import typer

from flexros.cli.output import print_json, say
from flexros.cli.progress import working

if TYPE_CHECKING:
    from flexros.installation.leftovers import Leftover

NOT_HEALTHY = 1
"""Exit code of the doctor where something is broken."""
_MARKS = {"ok": "ok", "limited": "limited", "broken": "BROKEN"}


def doctor(as_json: bool = typer.Option(False, "--json", help="Print JSON.")) -> int:
    """Check the installation: packages, ROS 2 and its middleware, shared memory, real-time rights, folders.

    "limited" is what works without something optional, or slower. The exit code is 1 where something is broken.
    """
    from flexros.installation.doctor import examine, healthy

    with working("looking at the installation"):
        findings = examine(dict(os.environ))
    well = healthy(findings)
    if as_json:
        print_json({"healthy": well, "findings": [finding.as_dict() for finding in findings]})
        return 0 if well else NOT_HEALTHY
    width = max(len(finding.name) for finding in findings)
    for finding in findings:
        say(f"{_MARKS[finding.state]:<8} {finding.name:<{width}}  {finding.text}")
        if finding.remedy:
            say(f"{'':<8} {'':<{width}}  -> {finding.remedy}")
    limited = sum(finding.state == "limited" for finding in findings)
    rest = f"; {limited} limited" if limited else ""
    say(f"FlexROS works here{rest}." if well else "FlexROS does not work here: see BROKEN above.")
    return 0 if well else NOT_HEALTHY


def clean(
    yes: bool = typer.Option(False, "--yes", help="Remove without asking."),
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> None:
    """Show the caches and temporary folders of FlexROS with their sizes, and remove them.

    What a running process uses is kept. Logs, reports and other results are never touched.
    """
    from flexros.installation.leftovers import find_leftovers, remove

    with working("measuring folders"):
        found = find_leftovers()
    if not as_json:
        _print_leftovers(found)
    idle = [leftover for leftover in found if not leftover.in_use]
    wanted = yes or (bool(idle) and not as_json and sys.stdin.isatty() and typer.confirm("Remove them?", err=True))
    removed = remove(idle) if wanted else ()
    if as_json:
        print_json(
            {
                "found": [leftover.as_dict() for leftover in found],
                "removed": [str(leftover.path) for leftover in removed],
                "freed_bytes": sum(leftover.size for leftover in removed),
            }
        )
        return
    if wanted:
        say(f"Removed {len(removed)} of {len(found)}, {_size(sum(leftover.size for leftover in removed))}.")
    elif idle:
        freed = _size(sum(leftover.size for leftover in idle))
        say(f"Nothing was removed; flexros clean --yes removes what is not in use, {freed}.")


def _print_leftovers(found: tuple[Leftover, ...]) -> None:
    if not found:
        say("Nothing to clean: no cache and no temporary folders.")
        return
    width = max(len(str(leftover.path)) for leftover in found)
    for leftover in found:
        what = f"{leftover.what} (in use, kept)" if leftover.in_use else leftover.what
        say(f"{leftover.path!s:<{width}}  {_size(leftover.size):>9}  {leftover.files:>5} files  {what}")


def _size(number: int) -> str:
    return f"{number / 1e6:.1f} MB" if number >= 1e5 else f"{number / 1e3:.1f} kB"
