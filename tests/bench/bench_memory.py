"""Peak memory and time of the commands on logs of half an hour at 2 kHz, each in a process of its own.

Prints a JSON list of rows. Two logs of `e12` are made once, in a temporary folder: a diagnosis experiment that is run,
analysed and diagnosed, and an identification of which frequency responses are estimated. Memory is the largest resident
size of the process, as the kernel counts it.

`python -m tests.bench.bench_memory FOLDER` keeps the logs in a folder, and uses those that are there.
"""

from __future__ import annotations

import json
import os
import shutil
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from tests.bench.bench_simulate import row

if TYPE_CHECKING:
    from collections.abc import Iterator

GOAL_GB = 1.5
RATE = 2000
"""Samples per second of `e12` [Hz]."""
DIAGNOSIS = ("diagnosis", "--set", "robot=e12", "--set", "diagnosis.length=1660")
IDENTIFICATION = ("identify_e12", "--set", "identification.blocks=17")
HIDDEN = ("--effect", "coulomb_friction@motor_1:level=0.5")
DONE = (0, 1)
"""Exit codes of a command that did its work; 1 where a diagnosis found a gap."""


def peak_of(*arguments: str) -> tuple[float, float]:
    """Run a command of FlexROS.

    Returns:
        Its largest resident memory [GB] and its time [s].
    """
    program = str(Path(sys.executable).with_name("flexros"))
    begin = time.perf_counter()
    quiet = [(os.POSIX_SPAWN_OPEN, 1, os.devnull, os.O_WRONLY, 0)]
    child = os.posix_spawn(program, [program, *arguments], os.environ, file_actions=quiet)
    # wait4 counts this child alone, RUSAGE_CHILDREN the largest of all.
    _, status, usage = os.wait4(child, 0)
    took, code = time.perf_counter() - begin, os.waitstatus_to_exitcode(status)
    if code not in DONE:
        raise RuntimeError(f"flexros {' '.join(arguments)} ended with code {code}")
    return 1024 * usage.ru_maxrss / 1e9, took


def samples_of(log: Path) -> int:
    """Return the number of samples of a log."""
    planned: int = json.loads((log / "provenance.json").read_text())["n_samples"]
    return planned


def measured(log: Path, what: str, *arguments: str) -> Iterator[dict[str, Any]]:
    """Measure one command; the log may be its result."""
    memory, took = peak_of(*arguments)
    n = samples_of(log)
    case = f"e12, {n} samples, {n / RATE / 60:.1f} min at {RATE} Hz"
    yield row(case, f"{what}, largest memory", memory, "GB", GOAL_GB)
    yield row(case, f"{what}, time", took, "s")


def all_rows(folder: Path) -> Iterator[dict[str, Any]]:
    """Make the logs that are not there, and measure all commands."""
    log, identified = folder / "diagnosis", folder / "identification"
    for made, scenario in ((log, (*DIAGNOSIS, *HIDDEN)), (identified, IDENTIFICATION)):
        if not made.exists():
            yield from measured(
                made, f"run {scenario[0]}", "run", *scenario, "--transport", "direct", "--out", str(made)
            )
    yield from measured(log, "analyze", "analyze", str(log))
    yield from measured(log, "analyze --report", "analyze", str(log), "--report", str(folder / "report.html"))
    yield from measured(identified, "identify frf", "identify", "frf", str(identified), "--out", str(folder / "frf.nc"))
    shutil.rmtree(folder / "found", ignore_errors=True)
    yield from measured(log, "diagnose", "diagnose", str(log), "--model", "e12", "--out", str(folder / "found"))


def main(arguments: list[str]) -> None:
    """Print all rows as one JSON list."""
    with TemporaryDirectory() as scratch:
        print(json.dumps(list(all_rows(Path(arguments[0] if arguments else scratch))), indent=1))


if __name__ == "__main__":
    main(sys.argv[1:])
