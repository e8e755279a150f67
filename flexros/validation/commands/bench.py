"""Command that measures speed, each figure compared with a peer in the same run."""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer
from rich.table import Table

from flexros.atomic_file import write_result
from flexros.cli.output import console, print_json
from flexros.cli.progress import progress_bar
from flexros.errors import InputError, RunError, unknown_name
from flexros.provenance import NUMERIC_PACKAGES, machine, versions

if TYPE_CHECKING:
    from collections.abc import Callable

FOLDER = Path(__file__).resolve().parents[3] / "tests" / "bench"
"""Benchmarks are part of the tests, because their peers are test dependencies."""

PACKAGES = (*NUMERIC_PACKAGES, "mujoco", "pin", "ros-jazzy-rclpy", "rclpy")
"""Packages whose versions are reported with the results: ours, the peers, and ROS from either source."""


def bench(
    name: list[str] = typer.Argument(None, help="Benchmarks to run, e.g. compile nodes; default: all."),
    out: Path = typer.Option(None, "--out", help="Write the rows with machine and versions to this .json or .md file."),
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> None:
    """Measure speed against peers (MuJoCo, SciPy, CasADi) in the same run; needs a checkout and the extra 'test'."""
    available = {path.stem.removeprefix("bench_"): path for path in sorted(FOLDER.glob("bench_*.py"))}
    if not available:
        raise InputError("benchmarks belong to a checkout of FlexROS; clone it and run `make bench` there")
    missing = [package for package in ("mujoco", "pinocchio") if importlib.util.find_spec(package) is None]
    if missing:
        raise InputError(
            f"benchmarks need {' and '.join(missing)} as peers; install the extra 'test' (make bench does)"
        )
    chosen = name or list(available)
    unknown = [one for one in chosen if one not in available]
    if unknown:
        raise unknown_name("benchmark", unknown[0], available)
    if out and not out.absolute().parent.is_dir():
        raise InputError(f"the result cannot be written to '{out}', its folder does not exist; make it or give another")
    results = {}
    with progress_bar() as bar:
        task = bar.add_task("", total=len(chosen))
        for done, one in enumerate(chosen):
            bar.update(task, description=f"measuring {one}", completed=done)
            results[one] = _measure(one, available[one])
    described = {**machine(), "versions": versions(PACKAGES)}
    content: dict[str, Any] = {"machine": described, "results": results}
    if out:
        text = markdown(described, results) if out.suffix == ".md" else json.dumps(content, indent=1) + "\n"
        write_result(out, text, "result")
    if as_json:
        print_json(content)
        return
    for one, rows in results.items():
        console.print(_table(one, rows))


def _measure(name: str, file: Path) -> list[dict[str, object]]:
    """Run one benchmark in a process of its own, so that none warms the caches of another."""
    done = subprocess.run(  # noqa: S603 - our own file
        [sys.executable, "-m", f"tests.bench.{file.stem}"],
        cwd=FOLDER.parents[1],
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        last = (done.stderr.strip().splitlines() or ["it printed no error"])[-1]
        raise RunError(f"benchmark {name} ended with code {done.returncode}: {last}")
    rows: list[dict[str, object]] = json.loads(done.stdout)
    return rows


def markdown(described: dict[str, object], results: dict[str, list[dict[str, object]]]) -> str:
    """Write results as a page that says where they were measured.

    Args:
        described: The machine, as from `flexros.provenance.machine`, and versions by package under "versions".
        results: Rows by benchmark.

    Returns:
        Markdown.
    """
    note = "Written by `make bench`. Peers are measured in the same run: compare ratios, absolute times vary."
    lines = ["# Benchmarks", "", note, ""]
    versions_used = described["versions"]
    assert isinstance(versions_used, dict)
    lines += [f"- {key}: {value}" for key, value in described.items() if key != "versions"]
    lines += ["- versions: " + ", ".join(f"{name} {version}" for name, version in versions_used.items())]
    for name, rows in results.items():
        keys = list(dict.fromkeys(key for row in rows for key in row))
        lines += ["", f"## {name}", "", "| " + " | ".join(keys) + " |", "|" + "---|" * len(keys)]
        lines += ["| " + " | ".join(_cell(row.get(key)) for key in keys) + " |" for row in rows]
    return "\n".join(lines) + "\n"


def _table(name: str, rows: list[dict[str, object]]) -> Table:
    """Make the table for the terminal; further columns are in the JSON and in the page."""
    keys = [key for key in ("case", "what", "value", "unit", "goal") if any(key in row for row in rows)]
    table = Table(*keys, title=name)
    for row in rows:
        table.add_row(*[_cell(row.get(key)) for key in keys])
    return table


def _cell(value: object) -> str:
    if value is None:
        return ""
    if isinstance(value, float):
        return f"{value:.0f}" if 1e4 <= abs(value) < 1e7 else f"{value:.4g}"
    return str(value)


COMMANDS: dict[str, Callable[..., Any]] = {"bench": bench}
HELP = ""
