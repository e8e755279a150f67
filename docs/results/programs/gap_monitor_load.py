"""Write gap_monitor_load.md, the processor load of the gap monitor: python docs/results/programs/gap_monitor_load.py.

All nodes are processes of their own; processor time is that of the operating system. It takes a quarter of an hour.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING

from flexros.scenario.scenario import load_scenario
from flexros_nodes.bringup.run_plan import IN_REAL_TIME

if TYPE_CHECKING:
    from collections.abc import Mapping

SETTLE = 25.0
"""Time for the start-up of nodes before the measurement [s]."""
SCENARIOS = {"e12": "circle_dae", "six_axis": "six_axis_moves"}
SHORT, LONG = 1.0, 31.0
"""Simulated times of the two runs in lock-step whose difference is taken [s], so that the start does not count."""
REAL_TIME, ROUNDS = 20.0, 3
"""Duration of a run in real time [s], and number of alternating runs with and without the monitor."""
RATE = 2000.0
"""Rate for which the load is reported [Hz]."""
TICK = os.sysconf("SC_CLK_TCK")

HEAD = """# Load of the gap monitor

Written by `python docs/results/programs/gap_monitor_load.py`.
Every node is a process of its own, on a machine with two
processors and other load. `Computing` is the processor time of the monitor without the reception of messages by the
middleware. The monitor runs at lower priority, the loop does not wait for it, and it skips what it does not receive.

"""
WAITING = """## In lock-step

Processor time per sample, without start-up, times 2000: the load of the node on one processor at 2 kHz. Then the
speed of the loop with and without the monitor, and the share of the states that the monitor received.

| robot | plant | monitor | computing | monitor / plant | samples/s without | samples/s with | received |
|---|---|---|---|---|---|---|---|
"""
PACED = """
## In real time

{rounds} runs of {duration:g} s at 2 kHz with and without the monitor, alternating: median, smallest and largest.
Plant, controller and feedforward have the priorities of `flexros run --realtime`, the monitor has none. Processor time
over wall time, of one processor; `late` are cycles that began more than a tenth of a period late.

| robot | monitor | computing | late without | late with | rate without | rate with | received |
|---|---|---|---|---|---|---|---|
"""


@dataclass(frozen=True)
class Run:
    """Measurements of a run.

    Attributes:
        plant: Figures of the plant.
        plant_time: Processor time of the plant [s].
        monitor_time: Processor time of the monitor [s], 0 without it.
        monitor: Figures of the monitor, empty without it.
    """

    plant: dict[str, float]
    plant_time: float
    monitor_time: float
    monitor: dict[str, float]


def page() -> str:
    """Measure, and write the page."""
    parts = [HEAD, WAITING, *(_in_lockstep(robot) for robot in SCENARIOS)]
    parts += [PACED.format(rounds=ROUNDS, duration=REAL_TIME), *(_in_real_time(robot) for robot in SCENARIOS)]
    return "".join(parts)


def _in_lockstep(robot: str) -> str:
    short, long = _run(robot, SHORT), _run(robot, LONG)
    unmonitored = _run(robot, LONG, watched=False)
    plant = (long.plant_time - short.plant_time) / (LONG - SHORT)
    states = max(long.monitor["states"] - short.monitor["states"], 1.0)
    monitor = RATE * (long.monitor_time - short.monitor_time) / states
    computing = RATE * (long.monitor["processor_time_s"] - short.monitor["processor_time_s"]) / states
    heard = min(long.monitor["states"] / (RATE * LONG), 1.0)
    return (
        f"| {robot} | {plant:.1%} | {monitor:.1%} | {computing:.1%} | {monitor / plant:.2f} | "
        f"{unmonitored.plant['samples_per_s']:.0f} | {long.plant['samples_per_s']:.0f} | {heard:.1%} |\n"
    )


def _in_real_time(robot: str) -> str:
    unmonitored, monitored = [], []
    for _ in range(ROUNDS):
        unmonitored.append(_run(robot, REAL_TIME, watched=False, real_time=True))
        monitored.append(_run(robot, REAL_TIME, real_time=True))
    cells = [
        _spread([100.0 * run.monitor_time / REAL_TIME for run in monitored], " %"),
        _spread([100.0 * run.monitor["processor_time_s"] / REAL_TIME for run in monitored], " %"),
        *(_spread([run.plant["late_percent"] for run in runs], " %") for runs in (unmonitored, monitored)),
        *(_spread([run.plant["rate_hz"] for run in runs], " Hz") for runs in (unmonitored, monitored)),
        _spread([100.0 * min(run.monitor["states"] / (RATE * REAL_TIME), 1.0) for run in monitored], " %"),
    ]
    return f"| {robot} | {' | '.join(cells)} |\n"


def _spread(values: list[float], unit: str) -> str:
    return f"{median(values):.1f}{unit} ({min(values):.1f} to {max(values):.1f})"


def _run(robot: str, duration: float, *, watched: bool = True, real_time: bool = False) -> Run:
    """Run a loop for a time [s], with or without the monitor."""
    with tempfile.TemporaryDirectory() as scratch:
        file = Path(scratch) / "run.yaml"
        file.write_text(json.dumps({**load_scenario(SCENARIOS[robot]).settings(), "duration": duration}))
        reports = {name: Path(scratch) / f"{name}.json" for name in ("plant", "gap_monitor")}
        values = [f"scenario:={file}", "observers:=0"]
        standing = IN_REAL_TIME if real_time else {}
        started = [_start(name, values, standing) for name in ("controller", "feedforward")]
        if watched:
            watching = ["model:=" + robot, f"report_file:={reports['gap_monitor']}"]
            started.append(_start("gap_monitor", watching, standing))
        time.sleep(SETTLE)
        before = _used(started[-1].pid)
        pace = f"real_time:={str(real_time).lower()}"
        plant = _start("plant", [*values, pace, f"report_file:={reports['plant']}"], standing)
        usage = os.wait4(plant.pid, 0)[2]
        time.sleep(3.0)
        used = _used(started[-1].pid) - before
        for one in started:
            one.send_signal(signal.SIGINT)
        for one in started:
            one.wait(60.0)
        return Run(
            plant=json.loads(reports["plant"].read_text())["figures"],
            plant_time=usage.ru_utime + usage.ru_stime,
            monitor_time=used if watched else 0.0,
            monitor=json.loads(reports["gap_monitor"].read_text())["figures"] if watched else {},
        )


def _start(node: str, values: list[str], standing: Mapping[str, Mapping[str, object]]) -> subprocess.Popen[bytes]:
    own = [f"{name}:={value}" for name, value in standing.get(node, {}).items()]
    arguments = [word for value in (*values, *own) for word in ("-p", value)]
    environment = {**os.environ, "ROS_DOMAIN_ID": "87", "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    command = [sys.executable, "-m", f"flexros_nodes.{node}", "--ros-args", *arguments]
    return subprocess.Popen(command, env=environment)  # noqa: S603


def _used(process: int) -> float:
    """Return the processor time of a process so far [s]."""
    fields = Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / TICK


def main() -> None:
    """Write the page."""
    assert __doc__ is not None
    argparse.ArgumentParser(description=__doc__.partition("\n")[0]).parse_args()
    (Path(__file__).parents[1] / "gap_monitor_load.md").write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    main()
