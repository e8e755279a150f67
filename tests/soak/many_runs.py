"""Many runs: in a row, without leaving anything behind, and at the same time, without hearing each other."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import tempfile
from contextlib import suppress
from pathlib import Path

import psutil

from flexros.logs.reader import read_log
from tests.nodes.conftest import differences
from tests.soak.own_mounts import mounts_are_allowed, with_mount
from tests.soak.result import Result, differing
from tests.soak.starting import CHECKOUT, direct_log, ending, scenario_file, start_run, user_environment

SHARED_MEMORY = Path("/dev/shm")

_IN_A_ROW = "import sys; from tests.soak.many_runs import runs_here; runs_here(sys.argv[1], *map(int, sys.argv[2:]))"


def in_a_row(folder: Path, in_one_process: int = 180, commands: int = 40, processes: int = 15) -> Result:
    """Run again and again: in one process, by commands, and with a process per node; then look for what is left.

    Where the system permits it, this happens with a shared memory of its own; else other programs disturb the count.
    """
    result = Result(
        ["runs", "aborted", "files in shared memory", "temporary files", "processes", "open files of a process"]
    )
    folder.mkdir(parents=True, exist_ok=True)
    command = [sys.executable, "-c", _IN_A_ROW, str(folder), *map(str, (in_one_process, commands, processes))]
    own = mounts_are_allowed(SHARED_MEMORY)
    if own:
        command = with_mount(command, SHARED_MEMORY, "1g")
    else:
        result.notes.append("Shared memory was that of the whole machine: this user may not mount a file system.")
    output = subprocess.check_output(command, cwd=CHECKOUT, env=user_environment(TMPDIR=str(folder)), text=True)
    for row in json.loads(output):
        left = [f"{row[name]} {name} left" for name in ("memory", "temporary", "processes") if row[name]]
        left += [f"{row['failed']} broken off"] * bool(row["failed"])
        left += row["names"]
        left += ["files stay open"] * (row["handles"][0] != row["handles"][1])
        texts = (
            row["what"],
            row["failed"],
            row["memory"],
            row["temporary"],
            row["processes"],
            " to ".join(map(str, row["handles"])),
        )
        result.add(*map(str, texts), wrong="; ".join(left))
    return result


def segments() -> set[str]:
    """Name the files of Fast DDS in shared memory."""
    return {path.name for path in SHARED_MEMORY.iterdir() if "fast" in path.name}


def others_of(folder: Path) -> list[str]:
    """Name the processes that were started with this folder for temporary files, but for this one and its parents.

    Those whose parent has ended are among them.
    """
    me = psutil.Process()
    known = {me.pid, *(one.pid for one in me.parents())}
    found = []
    for one in psutil.process_iter():
        with suppress(psutil.Error):
            if one.pid not in known and one.environ().get("TMPDIR") == str(folder):
                found.append(" ".join(one.cmdline())[:100] or one.name())
    return found


def runs_here(folder: str, in_one_process: int, commands: int, processes: int) -> None:
    """Do the runs, and print what they left, as JSON."""
    from flexros_nodes.bringup.run import run_scenario

    me, rows = psutil.Process(), []
    work = Path(folder)

    def left(what: str, before: set[str], failed: int, first: int) -> None:
        memory, others = segments() - before, others_of(work)
        temporary = [path.name for path in Path(tempfile.gettempdir()).iterdir() if path.name.startswith("flexros_")]
        rows.append(
            {
                "what": what,
                "failed": failed,
                "memory": len(memory),
                "temporary": len(temporary),
                "processes": len(others),
                "names": [*sorted(memory)[:20], *others[:20]],
                "handles": [first, me.num_fds()],
            }
        )

    before = segments()
    for layout, number in (("composed", commands), ("processes", processes)):
        failed, first = 0, me.num_fds()
        for _ in range(number):
            run = start_run(work, "circle_dae", "--layout", layout)
            failed += run.exit_code() != 0
            shutil.rmtree(work / "log", ignore_errors=True)
        left(f"{number} commands, {layout}", before, failed, first)
    failed, first = 0, 0
    for number in range(in_one_process):
        failed += run_scenario("circle_dae", work / "log").exit_code != 0
        shutil.rmtree(work / "log", ignore_errors=True)
        first = first or (me.num_fds() if number == min(5, in_one_process - 1) else 0)
    left(f"{in_one_process} in one process", before, failed, first)
    print(json.dumps(rows))


def side_by_side(folder: Path, runs: int = 8, rounds: int = 5, duration: float = 2.0) -> Result:
    """Begin runs at the same moment: each log must equal that of a run alone."""
    result = Result(["round", "runs at the same time", "different domains", "logs equal in every bit"])
    folder.mkdir(parents=True, exist_ok=True)
    scenario = scenario_file(folder, "circle_dae", duration)
    wanted = direct_log(scenario)
    for number in range(rounds):
        works = [folder / f"{number}_{i}" for i in range(runs)]
        for work in works:
            work.mkdir()
        started = [start_run(work, str(scenario)) for work in works]
        with ending(*started):
            codes = [run.exit_code(600.0) for run in started]
        domains = {run.figures()["ros_domain_id"] for run, code in zip(started, codes, strict=True) if code == 0}
        found = [
            differing(work.name, differences(wanted, read_log(work / "log")))
            for work in works
            if (work / "log").is_dir()
        ]
        wrong = [text for text in found if text] + [f"exit codes {codes}"] * any(codes)
        wrong += ["the same domain"] * (len(domains) < runs)
        equal = sum(not text for text in found)
        result.add(str(number + 1), str(runs), str(len(domains)), str(equal), wrong="; ".join(wrong))
        for work in works:
            shutil.rmtree(work)
    return result
