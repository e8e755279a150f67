"""The system clock set back, and forth again, while a run goes on."""

from __future__ import annotations

import shutil
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from flexros.logs.reader import read_log
from tests.nodes.conftest import differences
from tests.soak.result import Result, differing
from tests.soak.starting import await_samples, direct_log, ending, scenario_file, start_run

STEPS = (-20.0, 20.0)
"""Steps of the clock [s]; in between it is set back."""
OFF, RIGHT = 1.5, 0.5
"""For how long the clock is wrong, and right [s]."""
TIMES = 3
LONGEST = 0.1
"""Longest period in real time, that of the patience of a plant [s]."""


def clock_may_be_set() -> bool:
    """Return whether this user may set the clock, by setting it to what it shows."""
    try:
        time.clock_settime(time.CLOCK_REALTIME, time.clock_gettime(time.CLOCK_REALTIME))
    except OSError:
        return False
    return True


@contextmanager
def clock_set_right() -> Iterator[float]:
    """Yield the offset of the system clock from the steady one [s], and restore the clock after the block."""
    distance = time.clock_gettime(time.CLOCK_REALTIME) - time.clock_gettime(time.CLOCK_MONOTONIC)
    try:
        yield distance
    finally:
        set_clock(distance)


def set_clock(distance: float) -> None:
    """Set the system clock to an offset from the steady one [s]."""
    time.clock_settime(time.CLOCK_REALTIME, distance + time.clock_gettime(time.CLOCK_MONOTONIC))


def stepped(folder: Path, steps: Sequence[float] = STEPS, layouts: Sequence[str] = ("composed", "processes")) -> Result:
    """Set the clock of the machine off and right again, three times in a run in lock-step and in real time.

    In lock-step the log is that of an undisturbed run; in real time no period is longer than a plant has patience.
    """
    result = Result(["layout", "loop", "clock set forward by [s]", "exit code", "longest period [ms]", "log"])
    if not clock_may_be_set():
        result.notes.append("Not tried: this user may not set the clock.")
        return result
    for layout in layouts:
        for step in steps:
            for options in ((), ("--realtime",)):
                work = folder / f"{layout}{step}{len(options)}"
                work.mkdir(parents=True)
                _disturb(result, work, layout, step, *options)
                shutil.rmtree(work)
    return result


def _disturb(result: Result, work: Path, layout: str, step: float, *options: str) -> None:
    """Disturb one run, and add its row."""
    scenario = scenario_file(work, "circle_dae", 10.0)
    run = start_run(work, str(scenario), "--layout", layout, *options)
    with ending(run):
        await_samples(run, work, 30_000)
        with clock_set_right() as distance:
            for _ in range(TIMES):
                set_clock(distance + step)
                time.sleep(OFF)
                set_clock(distance)
                time.sleep(RIGHT)
        code = run.exit_code(600.0)
    wrong = [f"exit code {code}"] * (code != 0)
    row = [layout, "real time" if options else "lock-step", f"{step:+g}", str(code)]
    if options:
        longest = run.figures()["period_max_us"] / 1e6
        wrong += ["frozen"] * (longest > LONGEST)
        result.add(*row, f"{1e3 * longest:.1f}", "", wrong="; ".join(wrong))
        return
    found = differences(direct_log(scenario), read_log(work / "log"))
    wrong += [differing("the log", found)] * bool(found)
    result.add(*row, "", "differs" if found else "equal in every bit", wrong="; ".join(wrong))
