"""Write docs/results/endurance.md: python -m tests.soak.endurance_page [--only PART ...] [--again] [--out FOLDER].

Results of parts are kept in a work folder, and parts with a complete result there are not run again, so an aborted
campaign resumes. The page keeps the committed results of parts that were not run here.
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

PAGE, FIGURES = "endurance.md", "data/endurance.json"

HEAD = """# Endurance and faults

Written by `make soak` (`python -m tests.soak.endurance_page`), part by part; the tests contain short versions of the
parts. The machine had other load: speeds and late cycles are those of a loaded machine. The last column of a table is
"ok" or names the fault. A test proves that nodes use steady clocks only (`tests/nodes/runs/test_clock_jumps.py`).
"""


@dataclass(frozen=True)
class Part:
    """A part of the endurance test.

    Attributes:
        title: Heading on the page.
        text: Procedure and requirements.
        run: Function that runs the part in a folder of its own.
        values: Arguments of the full version.
        asked: Whether the part runs only when it is named, because it changes more than the checkout.
    """

    title: str
    text: str
    run: Callable[..., Result]
    values: dict[str, Any] = field(default_factory=dict)
    asked: bool = False


MEMORY = f"""Growth is the slope of a line through the means of {BLOCKS} equal spans after the first tenth of the
time, with its 95 % interval. Memory is flat when the interval is below {FLAT:g} bytes per sample of the loop and
the number of open files is constant. The recorder keeps the index of the log until it closes: 1 kB per chunk of
half a second, 1.1 bytes per sample, which is part of the growth."""

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
        f"One process holds all nodes, at 2 kHz. Due to the other load the plant may hold a command for 10 s. {MEMORY}",
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
        """`flexros run --layout processes`, SIGKILL during the run. Required: exit code 3, a message, a plant that
brakes, a readable log, no remaining process.""",
        killed_nodes.killed_in_a_run,
    ),
    "orders": Part(
        "Nodes killed and restarted in every order",
        """Nodes that were started one by one, as by `ros2 run`. Required: the plant reports the first kill, the log
is readable although its recorder is killed too, and all nodes, restarted in the same order and domain, give the log
of an undisturbed run.""",
        killed_nodes.killed_in_order,
    ),
    "back": Part(
        "A node killed and restarted while the others continue",
        "Behaviour of the loop. A restarted controller has lost its state, and a restarted plant begins a new run.",
        killed_nodes.killed_and_back,
    ),
    "frozen": Part(
        "A node is frozen",
        """SIGSTOP and SIGCONT in lock-step, time-outs 5 s. Required: a short stop changes no bit, a long one ends
the run in an orderly way; a plant may stop for any time.""",
        frozen_partners.frozen,
    ),
    "frozen_real_time": Part(
        "A controller is frozen in real time",
        """The plant holds the last command for 0.1 s, counts the missing commands, and then brakes. A controller
that resumes in time answers all missed measurements.""",
        frozen_partners.frozen_in_real_time,
    ),
    "stepped_clock": Part(
        "The system clock is set",
        """The clock of the machine is set wrong and right again, three times in a run. This part runs only when it
is named (`--only stepped_clock`). The libraries of the ROS 2 wheels wait on the system clock: before the kernel
woke the nodes when it is set, a loop in real time stopped until the clock was right again, here for 1.5 s. In real
time no period may be longer than 100 ms.""",
        stepped_clock.stepped,
        asked=True,
    ),
    "bad_transport": Part(
        "Messages lost, repeated and swapped",
        """A relay between plant, controller and feedforward loses 5 % of all messages, sends 5 % twice and swaps
5 % with the next one. The log must equal that of an undisturbed run.""",
        bad_transport.disturbed,
    ),
    "loss_real_time": Part(
        "Messages lost in real time",
        """Plant and controller lose 5 % of the commands, measurements and references, at 2 kHz. Commands and
measurements are not sent again, and the plant holds the last command; chunks of the reference are sent again.
Required: the loop continues, the log is complete, and no motor deviates from the undisturbed motion by more than
1 % of its range.""",
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
        """The same at 2 kHz, with one process per node. Required: the loop continues, and its log holds all
messages of its nodes. A sample that the controller did not receive has neither command nor reference and is not
counted as lost. Cycles are late from 50 us on, and discarding a flood takes longer.""",
        foreign_senders.flooded_in_real_time,
    ),
    "second_controller": Part(
        "Two controllers on one topic",
        """A second controller with other gains joins. The run aborts as soon as two commands for one sample differ.""",
        foreign_senders.second_controller,
    ),
    "full_disk": Part(
        "A full disk",
        "The log is recorded onto a file system of 64 kB or 2 MB.",
        full_disk.full_disk,
    ),
    "in_a_row": Part(
        "Hundreds of runs in a row",
        "The circle test, repeated. Required: no shared memory, temporary files, processes or open files remain.",
        many_runs.in_a_row,
    ),
    "side_by_side": Part(
        "Runs at the same time",
        "Eight runs begin at the same moment. None may receive messages of another one.",
        many_runs.side_by_side,
    ),
}
"""All parts by name, in the order of the page."""


def done(part: Part) -> dict[str, Any]:
    """Run a part; return its result with its time and the version of the code."""
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
    lines = [HEAD, *about, "", "| part | checks | passed | minutes | version |", "|---|---|---|---|---|"]
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
    """Run the parts without a result, and write the page after each part; return 1 if a check failed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--only",
        nargs="+",
        choices=list(PARTS),
        default=[name for name, part in PARTS.items() if not part.asked],
        metavar="PART",
        help=", ".join(PARTS),
    )
    parser.add_argument("--again", action="store_true", help="also run parts that have a result")
    parser.add_argument("--out", type=Path, default=CHECKOUT / "docs" / "results", help="folder of the page")
    parser.add_argument("--work", type=Path, default=CHECKOUT / "bags" / "soak", help="folder of finished parts")
    given = parser.parse_args()
    given.work.mkdir(parents=True, exist_ok=True)
    file, kept = given.out / FIGURES, given.work / Path(FIGURES).name
    file.parent.mkdir(parents=True, exist_ok=True)
    failed = False
    for name in given.only:
        finished = read_results(kept)
        if given.again or name not in finished:
            print(f"{name} ...", flush=True)
            try:
                found = done(PARTS[name])
            except Exception:  # noqa: BLE001 - the other parts are run all the same
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
