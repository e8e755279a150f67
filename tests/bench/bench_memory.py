"""Peak memory and time of the commands on logs of half an hour at 2 kHz, each in a process of its own.

Prints a JSON list of rows. Two logs of `e12` are made once, in a temporary folder: a diagnosis experiment that is run,
analysed and diagnosed, and an identification of which frequency responses are estimated. A third one, of
`four_mass_linear` at 1 kHz, is diagnosed with all effects competing. Memory is the largest resident size of the
process, as the kernel counts it.

`python -m tests.bench.bench_memory FOLDER` keeps the logs in a folder, and uses those that are there; with `--long` it
measures the diagnosis at 1 kHz alone.
"""

from __future__ import annotations

import json
import os
import shutil
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from tests.bench.bench_simulate import row

if TYPE_CHECKING:
    from collections.abc import Iterator

GOAL_GB = 1.5
RATE = 2000
"""Samples per second of `e12` [Hz]."""
LONG_RATE = 1000
"""The same of the log with all effects [Hz]."""
DIAGNOSIS = ("diagnosis", "--set", "robot=e12", "--set", "diagnosis.length=1660")
IDENTIFICATION = ("identify_e12", "--set", "identification.blocks=17")
HIDDEN = ("--effect", "coulomb_friction@motor_1:level=0.5")
LONG, LONG_ROBOT = "--long", "four_mass_linear"
LONG_DIAGNOSIS = ("diagnosis", "--set", "diagnosis.length=1800", "--set", "sample_time=0.001")
LONG_HIDDEN = ("--effect", "coulomb_friction@motor_1:level=0.1")
DONE = (0, 1)
"""Exit codes of a command that did its work; 1 where a diagnosis found a gap."""


@dataclass(frozen=True)
class Used:
    """What a command needs.

    Attributes:
        memory: Largest resident memory [GB].
        time: Time [s].
        processor: Processor time [s].
    """

    memory: float
    time: float
    processor: float


def used_by(*arguments: str) -> Used:
    """Run a command of FlexROS."""
    program = str(Path(sys.executable).with_name("flexros"))
    begin = time.perf_counter()
    quiet = [(os.POSIX_SPAWN_OPEN, 1, os.devnull, os.O_WRONLY, 0)]
    child = os.posix_spawn(program, [program, *arguments], os.environ, file_actions=quiet)
    # wait4 counts this child alone, RUSAGE_CHILDREN the largest of all.
    _, status, usage = os.wait4(child, 0)
    took, code = time.perf_counter() - begin, os.waitstatus_to_exitcode(status)
    if code not in DONE:
        raise RuntimeError(f"flexros {' '.join(arguments)} ended with code {code}")
    return Used(1024 * usage.ru_maxrss / 1e9, took, usage.ru_utime + usage.ru_stime)


def samples_of(log: Path) -> int:
    """Return the number of samples of a log."""
    planned: int = json.loads((log / "provenance.json").read_text())["n_samples"]
    return planned


def measured(log: Path, what: str, *arguments: str) -> Iterator[dict[str, Any]]:
    """Measure one command; the log may be its result."""
    used = used_by(*arguments)
    n = samples_of(log)
    case = f"e12, {n} samples, {n / RATE / 60:.1f} min at {RATE} Hz"
    yield row(case, f"{what}, largest memory", used.memory, "GB", GOAL_GB)
    yield row(case, f"{what}, time", used.time, "s")


def long_rows(folder: Path) -> Iterator[dict[str, Any]]:
    """Diagnose half an hour at 1 kHz, with all effects competing."""
    log, found = folder / "long", folder / "found_long"
    if not log.exists():
        robot = ("--set", f"robot={LONG_ROBOT}")
        used_by("run", *LONG_DIAGNOSIS, *robot, *LONG_HIDDEN, "--transport", "direct", "--out", str(log))
    shutil.rmtree(found, ignore_errors=True)
    used = used_by("diagnose", str(log), "--model", LONG_ROBOT, "--out", str(found))
    answer = json.loads((found / "diagnosis.json").read_text())
    causes = [(cause["effect"], cause["location"]) for cause in answer["causes"]]
    named = answer["verdict"] == "explained" and causes == [("coulomb_friction", "motor_1")]
    n = samples_of(log)
    case = f"{LONG_ROBOT}, {n} samples, {n / LONG_RATE / 60:.1f} min at {LONG_RATE} Hz, all effects"
    yield row(case, "diagnose, largest memory", used.memory, "GB", GOAL_GB)
    yield row(case, "diagnose, time", used.time, "s")
    yield row(case, "diagnose, processor time", used.processor, "s")
    yield row(case, "verdict names the hidden effect alone (1: yes)", float(named), "1", 1.0)


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
    yield from long_rows(folder)


def main(arguments: list[str]) -> None:
    """Print all rows as one JSON list."""
    with TemporaryDirectory() as scratch:
        folders = [one for one in arguments if one != LONG]
        rows = long_rows if LONG in arguments else all_rows
        print(json.dumps(list(rows(Path(folders[0] if folders else scratch))), indent=1))


if __name__ == "__main__":
    main(sys.argv[1:])
