"""Fuzz every reader and truncate a log; `python -m tests.fuzz.campaign MINUTES FOLDER` writes fuzzing.md."""

from __future__ import annotations

import json
import resource
import signal
import sys
import tempfile
import time
import warnings
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from types import FrameType

from hypothesis import HealthCheck, Phase, given, seed, settings

from flexros.atomic_file import write_whole
from tests.fuzz.fixed_faults import FIXED_FAULTS
from tests.fuzz.hostile import HOSTILE
from tests.fuzz.readers import READERS, Reader, outcome
from tests.logs.cut_log import Recovery, chunk_edges, cuts_of, in_small_chunks, recovery

CHECKOUT = Path(__file__).parents[2]
SAMPLE = CHECKOUT / "bags" / "sample_circle_dae" / "sample_circle_dae_0.mcap"
BATCH = 500
"""Inputs of one run of Hypothesis; the next run has another seed."""
LONGEST = 60
"""Processor time after which reading counts as a hang [s]."""
ROOM = 2 * 2**30
"""Memory in addition to that of the process at the start [byte]."""
N_CUTS = 5_000
HEAD = """# Fuzzing

Written by `make fuzz`, {minutes:g} minutes of processor time. Every reader of foreign data gets damaged inputs (bits,
bytes, claimed lengths, parts truncated, removed, inserted or repeated, records in any order with correct checksums) and
generated ones, from Hypothesis with a new seed for every {batch}. An input must give a valid result or be refused with
one printable sentence. Everything else is a fault: another exception, a hang of {longest} s, {room} MB more memory than
at the start. [Limits](../reference/limits.md) lists the limits of size.
"""


@dataclass
class Tally:
    """Results of the inputs of one reader.

    Attributes:
        what: Kind of input.
        outcomes: Number of inputs by outcome: read, refused, fault.
        faults: First input of each kind of fault, as text, by kind.
        slowest: Longest time for an input [s] (processor time).
    """

    what: str
    outcomes: Counter[str] = field(default_factory=Counter)
    faults: dict[str, str] = field(default_factory=dict)
    slowest: float = 0.0

    def read(self, reader: Reader, data: bytes) -> None:
        """Read an input and count its outcome."""
        began = time.process_time()
        signal.setitimer(signal.ITIMER_PROF, LONGEST)
        try:
            self.outcomes[outcome(reader, data)] += 1
        except Exception as error:  # noqa: BLE001 - each is a fault that is reported
            self.outcomes["fault"] += 1
            trace = error.__traceback__
            while trace is not None and trace.tb_next is not None:
                trace = trace.tb_next
            location = f"{Path(trace.tb_frame.f_code.co_filename).name}:{trace.tb_lineno}" if trace else ""
            self.faults.setdefault(f"{type(error).__name__} at {location}", repr(data[:2000]))
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0)
        self.slowest = max(self.slowest, time.process_time() - began)


def _hang(number: int, frame: FrameType | None) -> None:
    raise TimeoutError(f"no end after {LONGEST} s")


def fuzz(name: str, budget: float) -> Tally:
    """Fuzz a reader for a time.

    Args:
        name: Name of the reader.
        budget: Processor time [s].
    """
    reader, began, batch = READERS[name], time.process_time(), 0
    tally = Tally(reader.what)
    while time.process_time() - began < budget:
        batch += 1

        @seed(batch)
        @settings(
            max_examples=BATCH,
            deadline=None,
            database=None,
            phases=[Phase.generate],
            suppress_health_check=list(HealthCheck),
        )
        @given(reader.inputs)
        def run(data: bytes) -> None:
            tally.read(reader, data)

        run()
    return tally


def hostile() -> Tally:
    """Read inputs that are written to exhaust memory or time, or to end the process."""
    tally = Tally("claimed sizes, expansion and nesting, written by hand")
    for reader, make in HOSTILE.values():
        tally.read(READERS[reader], make())
    return tally


def cut() -> tuple[int, Recovery]:
    """Cut the sample log, in chunks of 10 kB, at many bytes; return the number of chunks, and the content read."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.mcap"
        in_small_chunks(SAMPLE, path, 10_000)
        content = path.read_bytes()
        return len(chunk_edges(content)), recovery(path, cuts_of(content, N_CUTS))


def _row(what: str, outcomes: Counter[str], slowest: float) -> str:
    numbers = [outcomes[kind] for kind in ("read", "refused", "fault")]
    return f"| {what} | {sum(numbers)} | {numbers[0]} | {numbers[1]} | {numbers[2]} | {slowest:.2g} |"


def page(tallies: list[Tally], n_chunks: int, found: Recovery, minutes: float) -> str:
    """Write the page."""
    rows = [HEAD.format(batch=BATCH, longest=LONGEST, room=ROOM // 2**20, minutes=minutes)]
    rows += ["| reader | inputs | read | refused | faults | slowest [s] |", "|---|---|---|---|---|---|"]
    rows += [_row(tally.what, tally.outcomes, tally.slowest) for tally in tallies]
    together = sum((tally.outcomes for tally in tallies), Counter[str]())
    rows += [_row("all", together, max(tally.slowest for tally in tallies)), ""]
    open_faults = [f"- {tally.what}: {kind}" for tally in tallies for kind in tally.faults]
    rows += ["Open faults:", "", *open_faults, ""] if open_faults else ["No open faults.", ""]
    rows += [f"## Faults found and fixed: {len(FIXED_FAULTS)}", "", "Each has a test.", ""]
    rows += [f"- {what}: {before}" for what, before in FIXED_FAULTS.items()]
    rows += ["", "## Logs truncated at any byte", ""]
    rows.append(
        f"The sample log, rewritten in {n_chunks} chunks, was truncated at {found.n_cuts} positions: around the begin "
        f"and end of every chunk, and at random ones. Of {found.n_expected} messages of complete chunks {found.n_read} "
        f"were read bit-equal: {100 * found.share:.6g} %. Other messages read: {found.n_wrong}."
    )
    return "\n".join(rows) + "\n"


def main(minutes: float, folder: Path) -> int:
    """Run everything; the exit code is 1 where a fault is open or a message was lost."""
    warnings.simplefilter("ignore")
    signal.signal(signal.SIGPROF, _hang)
    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + ROOM, used + ROOM))
    tallies = [hostile()]
    for name in READERS:
        tallies.append(fuzz(name, 60 * minutes / len(READERS)))
        print(json.dumps({"reader": name, **tallies[-1].outcomes, "faults": tallies[-1].faults}), flush=True)
    n_chunks, found = cut()
    write_whole(folder / "fuzzing.md", page(tallies, n_chunks, found, minutes))
    return int(any(tally.faults for tally in tallies) or found.share < 1 or found.n_wrong > 0)


if __name__ == "__main__":
    sys.exit(main(float(sys.argv[1]), Path(sys.argv[2])))
