"""Write docs/results/endurance.md: python -m tests.soak.endurance_page [--only PART ...] [--again] [--out FOLDER].

Results of parts are kept in a folder of work, and parts that have a whole one there are not run again; so a broken-off
campaign goes on where it was. Parts that were not run here stay on the page as they are.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
import traceback
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import datetime, timezone
from pathlib import Path
from time import monotonic
from typing import Any

from flexros.atomic_file import write_whole
from flexros.provenance import code_version, machine, versions
from tests.soak import (
    bad_transport,
    foreign_senders,
    frozen_partners,
    full_disk,
    killed_nodes,
    long_runs,
    many_runs,
    stepped_clock,
)
from tests.soak.result import Result
from tests.soak.starting import CHECKOUT
from tests.soak.watching import BLOCKS, FLAT

PAGE, FIGURES = "endurance.md", "endurance.json"

HEAD = """# Endurance and faults

Written by `make soak` (`python -m tests.soak.endurance_page`), part by part; short versions of the parts are among the
tests. Everything ran on this machine, with other work: speeds and late cycles are those of a loaded machine. The last
column of a table says "ok", or what was not as it must be. That nodes look at steady clocks alone is tested
(`tests/nodes/runs/test_clock_jumps.py`).
"""


@dataclass(frozen=True)
class Part:
    """A part of the endurance test.

    Attributes:
        title: Heading on the page.
        text: What is done, and what must come of it.
        run: Does it in a folder of its own.
        values: Parameters of the full version.
        asked: Whether it is run only where it is named, because it touches more than the checkout.
    """

    title: str
    text: str
    run: Callable[..., Result]
    values: dict[str, Any] = field(default_factory=dict)
    asked: bool = False


MEMORY = f"""Growth is the slope of a line through the means of {BLOCKS} equal spans, with its 95 % interval, after the
first tenth of the time. Memory is flat when the interval lies below {FLAT:g} bytes per sample of the loop, and the
number of open files never changes. The recorder keeps the index of the log until it closes: 1 kB for each chunk of half
a second, 1.1 bytes per sample; it is part of the growth."""

PARTS = {
    "lock_step": Part(
        "30 minutes in lock-step, composed",
        f"One process holds all nodes. {MEMORY}",
        long_runs.long_run,
        {"layout": "composed", "duration": 1800.0, "period": 0.25, "real_time": False},
    ),
    "lock_step_processes": Part(
        "30 minutes in lock-step, one process per node",
        MEMORY,
        long_runs.long_run,
        {"layout": "processes", "duration": 1800.0, "period": 0.5, "real_time": False},
    ),
    "real_time": Part(
        "30 minutes of wall clock in real time",
        f"One process holds all nodes, 2 kHz. Beside other work: the plant may hold a command for 10 s. {MEMORY}",
        long_runs.long_run,
        {"layout": "composed", "duration": 1800.0, "period": 3.0, "real_time": True},
    ),
    "real_time_processes": Part(
        "15 minutes of wall clock in real time, one process per node",
        f"With real-time priority for all nodes. {MEMORY}",
        long_runs.long_run,
        {"layout": "processes", "duration": 900.0, "period": 3.0, "real_time": True},
    ),
    "killed": Part(
        "A node of a run is killed",
        """`flexros run --layout processes`, SIGKILL in the midst: exit code 3, a sentence, a plant that brakes, a
readable log, no process left.""",
        killed_nodes.killed_in_a_run,
    ),
    "orders": Part(
        "Nodes killed and started again in every order",
        """Nodes that were started by themselves, as by `ros2 run`. After the first kill the plant notices, the log is
readable though its recorder is killed too, and all nodes started again in the same order and domain give the log of an
undisturbed run.""",
        killed_nodes.killed_in_order,
    ),
    "back": Part(
        "A node killed and started again while the others go on",
        "What becomes of the loop. A controller that comes back has lost its state, and a plant begins anew.",
        killed_nodes.killed_and_back,
    ),
    "frozen": Part(
        "A node is frozen",
        """SIGSTOP and SIGCONT in lock-step, time-outs 5 s: a short stop changes no bit, a long one ends the run in
order; a plant may stop for as long as one likes.""",
        frozen_partners.frozen,
    ),
    "frozen_real_time": Part(
        "A controller is frozen in real time",
        """The plant holds the last command for 0.1 s, counts what is missing, and then brakes. A controller that comes
back in time answers all that it has missed.""",
        frozen_partners.frozen_in_real_time,
    ),
    "stepped_clock": Part(
        "The system clock is set",
        """The clock of the machine is set off and right again, three times in a run; so this part is run by its name
only (`--only stepped_clock`). The libraries of the wheels wait on the system clock: before nodes were woken by the
kernel when it is set, a loop in real time stood still until the clock was right again, for 1.5 s here. In real time no
period may be longer than 100 ms.""",
        stepped_clock.stepped,
        asked=True,
    ),
    "bad_transport": Part(
        "Messages lost, repeated and swapped",
        """A node stands between plant, controller and feedforward; it loses 5 % of all messages, sends 5 % twice and
swaps 5 % with the next one. The log must equal that of an undisturbed run.""",
        bad_transport.disturbed,
    ),
    "loss_real_time": Part(
        "Messages lost in real time",
        """Plant and controller do not see 5 % of the commands, measurements and references, at 2 kHz: commands and
measurements are not sent again, the plant holds the last command; chunks of the reference are. The loop has to go on,
nothing may be missing in the log, and no motor may leave the undisturbed motion by more than 1 % of its range.""",
        bad_transport.lossy_in_real_time,
    ),
    "flood": Part(
        "Floods in lock-step",
        """A foreign node sends 10,000 messages per second while the loop runs. The log must equal that of an
undisturbed run.""",
        foreign_senders.flooded,
    ),
    "flood_real_time": Part(
        "Floods in real time",
        """The same at 2 kHz, with one process per node: the loop has to go on, and its log must hold all that its nodes
have sent: a sample that the controller never saw has neither command nor reference, and is not lost. Cycles count as
late from 50 us on, and looking through a flood takes longer.""",
        foreign_senders.flooded_in_real_time,
    ),
    "second_controller": Part(
        "Two controllers on one topic",
        """A second controller with other gains joins: the run breaks off as soon as two commands for one sample
differ.""",
        foreign_senders.second_controller,
    ),
    "full_disk": Part(
        "A full disk",
        "The log is recorded onto a file system of 64 kB or 2 MB.",
        full_disk.full_disk,
    ),
    "in_a_row": Part(
        "Hundreds of runs in a row",
        "The circle test again and again. Nothing may stay: no shared memory, temporary files, processes, open files.",
        many_runs.in_a_row,
    ),
    "side_by_side": Part(
        "Runs at the same time",
        "Eight runs begin at the same moment. None may hear another one.",
        many_runs.side_by_side,
    ),
}
"""All parts by name, in the order of the page."""


def done(part: Part) -> dict[str, Any]:
    """Run a part; give its result with its time and the version of the code."""
    began, load = monotonic(), os.getloadavg()[0]
    with tempfile.TemporaryDirectory(prefix="soak_", dir=os.environ.get("TMPDIR")) as work:
        result = part.run(Path(work), **part.values)
    return {
        **result.as_dict(),
        "wall_time_s": monotonic() - began,
        "load": [load, os.getloadavg()[0]],
        "date": f"{datetime.now(timezone.utc):%Y-%m-%d}",
        "commit": code_version(),
    }


def read_results(file: Path) -> dict[str, dict[str, Any]]:
    """Read results of parts; none where there is no file."""
    results: dict[str, dict[str, Any]] = json.loads(file.read_text(encoding="utf-8")) if file.is_file() else {}
    return results


def page(results: dict[str, dict[str, Any]]) -> str:
    """Write the page from the results of parts."""
    described = machine()
    about = [f"- {key}: {value}" for key, value in described.items()]
    about.append("- versions: " + ", ".join(f"{name} {text}" for name, text in versions().items()))
    lines = [HEAD, *about, "", "| part | tried | as it must be | minutes | version |", "|---|---|---|---|---|"]
    sections = []
    for name, part in PARTS.items():
        if name not in results:
            lines.append(f"| {part.title} | not run yet | | | |")
            continue
        found = results[name]
        result = Result(found["columns"], found["rows"], found["notes"])
        counts = f"{len(result.rows)} | {result.survived} | {found['wall_time_s'] / 60.0:.1f}"
        lines.append(f"| {part.title} | {counts} | {found['commit']}, {found['date']} |")
        sections += [f"\n## {part.title}\n", part.text, "", result.table()]
        if result.notes:
            sections += ["", " ".join(result.notes)]
    return "\n".join([*lines, *sections]) + "\n"


def main() -> int:
    """Run what has no result yet, and write the page after each part; 1 if something was not as it must be."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--only",
        nargs="+",
        choices=list(PARTS),
        default=[name for name, part in PARTS.items() if not part.asked],
        metavar="PART",
        help=", ".join(PARTS),
    )
    parser.add_argument("--again", action="store_true", help="run parts that have a result, too")
    parser.add_argument("--out", type=Path, default=CHECKOUT / "docs" / "results", help="folder of the page")
    parser.add_argument("--work", type=Path, default=CHECKOUT / "bags" / "soak", help="folder of finished parts")
    given = parser.parse_args()
    given.work.mkdir(parents=True, exist_ok=True)
    file, kept = given.out / FIGURES, given.work / FIGURES
    failed = False
    for name in given.only:
        finished = read_results(kept)
        if given.again or name not in finished:
            print(f"{name} ...", flush=True)
            try:
                found = done(PARTS[name])
            except Exception:  # noqa: BLE001 - the other parts shall be run all the same
                traceback.print_exc()
                failed = True
                continue
            # read again: another part may have finished in parallel
            finished = {**read_results(kept), name: found}
            write_whole(kept, json.dumps(finished, indent=1) + "\n")
        results = {**read_results(file), name: finished[name]}
        write_whole(file, json.dumps(results, indent=1) + "\n")
        write_whole(given.out / PAGE, page(results))
        wrong = Result(results[name]["columns"], results[name]["rows"]).wrong
        failed = failed or bool(wrong)
        for row in wrong:
            print(f"{name}: {row}", flush=True)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
