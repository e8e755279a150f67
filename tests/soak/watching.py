"""Memory and file handles of processes over time, and how fast they grow."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np
import psutil
from scipy.stats import t as student

BLOCKS = 20
"""Means of so many equal spans of time are regressed: neighbouring samples of memory are not independent, chosen."""

WARM_UP, CLOSE = 0.1, 0.02
"""Shares of the time left out at the beginning and at the end, chosen."""

FLAT = 2.0
"""Memory is flat if it surely grows by less than this [bytes per sample of the loop], chosen: the index of the log,
which is kept until the log closes, takes 1.1, and the smallest object of Python that a sample could leave behind 16."""


@dataclass(frozen=True)
class Growth:
    """Growth of a process.

    Attributes:
        first_mb: Resident memory after the warm-up [MB].
        last_mb: Resident memory before the end [MB].
        slope: Growth of memory [bytes per sample of the loop].
        half_width: Half width of its 95 % interval.
        handles: Fewest and most open files.
        threads: Fewest and most threads.
    """

    first_mb: float
    last_mb: float
    slope: float
    half_width: float
    handles: tuple[int, int]
    threads: tuple[int, int]

    @property
    def is_flat(self) -> bool:
        return self.slope + self.half_width < FLAT and self.handles[0] == self.handles[1]

    def as_dict(self) -> dict[str, object]:
        return {**asdict(self), "flat": self.is_flat}


Sample = tuple[float, float, int, int]
"""Time [s], resident memory [bytes], open files, threads."""


def name_of(process: psutil.Process) -> str:
    """Name a process by its node."""
    for word in process.cmdline():
        if word.startswith("flexros_nodes."):
            return str(word.removeprefix("flexros_nodes."))
    return "run"


@dataclass
class Watched:
    """Samples of a process.

    Attributes:
        samples: Looks at it, the first one first.
        files: What its open files were at the latest look at them.
        opened: Files that were opened, and those that were closed, since the look before, with the time [s].
    """

    samples: list[Sample] = field(default_factory=list)
    files: Counter[str] = field(default_factory=Counter)
    opened: list[tuple[float, list[str], list[str]]] = field(default_factory=list)

    def look(self, process: psutil.Process, now: float) -> None:
        """Take a sample, and look at the open files where their number is another one."""
        row = (now, float(process.memory_info().rss), process.num_fds(), process.num_threads())
        if not self.samples or row[2] != self.samples[-1][2]:
            files = open_files(process.pid)
            if self.samples:
                self.opened.append((now, sorted(files - self.files), sorted(self.files - files)))
            self.files = files
        self.samples.append(row)


def open_files(pid: int) -> Counter[str]:
    """Count the open files of a process by what they are."""
    files: Counter[str] = Counter()
    for link in Path(f"/proc/{pid}/fd").iterdir():
        with suppress(OSError):
            files[str(link.readlink())] += 1
    return files


def watch(pid: int, over: Callable[[], bool], period: float) -> dict[str, Watched]:
    """Sample a process and its children until something is over.

    Args:
        pid: The process.
        over: Whether to stop.
        period: Time between samples [s].

    Returns:
        What was seen by name of the process.
    """
    root = psutil.Process(pid)
    tree = {name_of(one): one for one in (root, *root.children(recursive=True))}
    seen = {name: Watched() for name in tree}
    while not over():
        now = time.monotonic()
        for name, process in tree.items():
            with suppress(psutil.NoSuchProcess, psutil.ZombieProcess, FileNotFoundError):
                seen[name].look(process, now)
        time.sleep(period)
    return seen


def growth_counts(at: float, begin: float, end: float) -> bool:
    """Return whether a time is neither in the warm-up of a run nor at its close."""
    return WARM_UP <= (at - begin) / max(end - begin, 1e-9) <= 1 - CLOSE


def growth(samples: list[Sample], samples_per_second: float) -> Growth:
    """Regress the memory of a process.

    Args:
        samples: What was seen, from the first sample of the loop to the last.
        samples_per_second: Speed of the loop [1/s].

    Returns:
        Slope, with a 95 % interval from the means of 20 spans, handles and threads.
    """
    n = len(samples)
    rows = np.array(samples[round(WARM_UP * n) : n - max(round(CLOSE * n), 1)])
    if len(rows) < 2 * BLOCKS:
        raise ValueError(f"{len(rows)} samples are too few for {BLOCKS} spans")
    means = np.array([block[:, :2].mean(axis=0) for block in np.array_split(rows, BLOCKS)])
    x, y = means[:, 0] - means[:, 0].mean(), means[:, 1]
    slope = float(x @ y / (x @ x))
    rest = y - y.mean() - slope * x
    spread = float(np.sqrt(rest @ rest / (BLOCKS - 2) / (x @ x)))
    half_width = float(student.ppf(0.975, BLOCKS - 2)) * spread
    return Growth(
        first_mb=float(rows[0, 1]) / 1e6,
        last_mb=float(rows[-1, 1]) / 1e6,
        slope=slope / samples_per_second,
        half_width=half_width / samples_per_second,
        handles=(int(rows[:, 2].min()), int(rows[:, 2].max())),
        threads=(int(rows[:, 3].min()), int(rows[:, 3].max())),
    )
