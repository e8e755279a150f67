"""Speed of the loop over ROS 2 topics, and how well real time is kept, compared with peers measured in the same run.

Prints one JSON list. The peer of lock-step is the executor that rclpy uses by default; that of real time is a bare
loop that sleeps and does nothing else, which shows what the machine itself allows at that moment.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from contextlib import contextmanager, nullcontext
from math import inf
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING
from unittest.mock import patch

from flexros.scenario.scenario import load_scenario
from flexros_nodes.bringup.run import run_scenario
from flexros_nodes.protocol.real_time.bare_loop import bare_loop
from flexros_nodes.shell import spinning

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from flexros.scenario.scenario import Scenario
    from flexros_nodes.bringup.run_plan import RunSummary

T = 5e-4
REPEATS = 3
DURATION = 8.0
MOST_LATE, ALWAYS_LATE = 3.0, 0.5
"""Goal of the late cycles: this many times those of a bare loop, plus a share [%]."""


def scenario(name: str, duration: float) -> Scenario:
    """Load a scenario and give it a length [s]."""
    return load_scenario(name).with_values({"duration": duration})


def run(what: Scenario, layout: str, *, record: bool = True, real_time: bool = False) -> RunSummary:
    """Run once, with the log in a folder that is removed."""
    with tempfile.TemporaryDirectory() as name:
        summary = run_scenario(what, Path(name) / "log" if record else None, layout, real_time=real_time)
    if summary.exit_code or summary.missing:
        raise RuntimeError(f"the run failed: {summary.message or f'{summary.missing} samples are missing'}")
    return summary


@contextmanager
def default_executor() -> Iterator[None]:
    """Use rclpy's SingleThreadedExecutor in the block."""
    with patch.object(spinning, "EventsExecutor", None):
        yield


def speed_row(what: str, given: Scenario, layout: str, goal: float | None, *, record: bool = True) -> dict[str, object]:
    """Measure samples per second, the median and the best of several runs."""
    speeds = [run(given, layout, record=record).samples_per_second for _ in range(REPEATS)]
    return {"what": what, "value": median(speeds), "best": max(speeds), "unit": "samples/s", "goal": goal}


def lock_step_rows() -> list[dict[str, object]]:
    """Lock-step in both layouts."""
    circle = scenario("circle_dae", 10.0)
    composed = speed_row("lock-step, composed, 5 topics recorded", circle, "composed", 15_000)
    without = speed_row("lock-step, composed, not recorded", circle, "composed", None, record=False)
    with default_executor():
        peer = speed_row(
            "lock-step, composed, 5 topics recorded, SingleThreadedExecutor",
            scenario("circle_dae", 1.0),
            "composed",
            None,
        )
    cost = 1e6 * (1.0 / float(str(composed["best"])) - 1.0 / float(str(without["best"])))
    return [
        composed,
        peer,
        without,
        {"what": "recorder per sample, 5 topics, composed", "value": cost, "unit": "us", "goal": None},
        speed_row("lock-step, composed, six_axis", scenario("six_axis_moves", 5.0), "composed", None),
        speed_row("lock-step, one process per node, 5 topics recorded", circle, "processes", 4_000),
        speed_row("lock-step, one process per node, not recorded", circle, "processes", None, record=False),
    ]


def bare_row() -> dict[str, object]:
    """Measure the schedule of an empty loop."""
    statistics = bare_loop(T, DURATION)
    assert statistics is not None
    return timing_row("real time, bare loop without nodes", statistics.as_dict(), None)


def real_time_row(what: str, given: Scenario, layout: str, goal: float, *, record: bool) -> dict[str, object]:
    """Measure one run in real time; one that was aborted has no value."""
    try:
        summary = run(given, layout, record=record, real_time=True)
    except RuntimeError as error:
        print(f"{what}: {error}", file=sys.stderr)
        return {"what": what, "value": None, "unit": "% late", "goal": goal}
    return timing_row(what, dict(summary.timing), goal)


def timing_row(what: str, timing: dict[str, float], goal: float | None) -> dict[str, object]:
    """Return the row of a real-time run; its goal is that of the late cycles."""
    return {
        "what": what,
        "value": timing["late_percent"],
        "unit": "% late",
        "goal": goal,
        "rate_hz": timing["rate_hz"],
        "period_p99_us": timing["period_p99_us"],
        "period_max_us": timing["period_max_us"],
        "bare_late_percent": timing.get("bare_late_percent"),
        "missed_commands": timing.get("missed_commands"),
        "real_time_priority": timing.get("real_time_priority"),
    }


@contextmanager
def busy_processors() -> Iterator[None]:
    """Keep as many ordinary processes busy as there are processors."""
    others = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(os.cpu_count() or 1)]
    try:
        yield
    finally:
        for other in others:
            other.kill()
            other.wait()


def real_time_rows() -> list[dict[str, object]]:
    """Real time at 2 kHz in both layouts, each with and without a recorder, by itself and beside busy processors.

    The median run of several rounds, in which an aborted run counts as the worst; the goal of each is relative to the
    bare loop of the same round.
    """
    circle = scenario("circle_dae", DURATION)
    found = []
    for load, beside in (("", nullcontext), (", beside busy processors", busy_processors)):
        rounds = []
        for _ in range(REPEATS):
            with beside():
                bare = bare_row()
                goal = MOST_LATE * float(str(bare["value"])) + ALWAYS_LATE
                rows = [bare]
                for layout in ("composed", "processes"):
                    for record in (False, True):
                        what = f"real time, {layout}, {'5 topics recorded' if record else 'not recorded'}"
                        rows.append(real_time_row(what, circle, layout, goal, record=record))
            rounds.append([{**row, "what": f"{row['what']}{load}"} for row in rows])
        found += [median_row(rows) for rows in zip(*rounds, strict=True)]
    return found


def median_row(rows: Sequence[dict[str, object]]) -> dict[str, object]:
    """Return the row with the median value, the best value and the number of aborted runs."""
    ordered = sorted(rows, key=lambda row: inf if row["value"] is None else float(str(row["value"])))
    aborted = sum(row["value"] is None for row in rows)
    return {**ordered[len(ordered) // 2], "best": ordered[0]["value"], "aborted": aborted}


def main() -> None:
    """Print all rows."""
    print(json.dumps([*lock_step_rows(), *real_time_rows()]))


if __name__ == "__main__":
    main()
