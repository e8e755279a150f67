"""What the gap monitor costs beside a loop: nodes as processes, their processor time as the system counts it."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from flexros.config.scenario import load_scenario

SETTLE = 25.0
"""Time for which nodes that have been started are left to make what they need [s]."""
SCENARIOS = {"e12": "circle_dae", "six_axis": "six_axis_moves"}
SHORT, LONG = 1.0, 31.0
"""Simulated times of the two runs whose difference is taken [s], so that the start does not count."""
RATE = 2000.0
"""Rate for which the load is told [Hz]."""
TICK = os.sysconf("SC_CLK_TCK")


def measured_load() -> list[dict[str, Any]]:
    """Measure all robots: in lock-step, as fast as the machine permits, with and without the monitor."""
    return [_measured(robot, scenario) for robot, scenario in SCENARIOS.items()]


def _measured(robot: str, scenario: str) -> dict[str, Any]:
    short, long, alone = (_run(robot, scenario, *one) for one in ((SHORT, True), (LONG, True), (LONG, False)))
    samples = RATE * (LONG - SHORT)
    return {
        "robot": robot,
        "plant": RATE * (long["plant"] - short["plant"]) / samples,
        "monitor": RATE * (long["monitor"] - short["monitor"]) / max(long["heard"] - short["heard"], 1),
        "computing": RATE * (long["computing"] - short["computing"]) / max(long["heard"] - short["heard"], 1),
        "heard": long["heard"] / (RATE * LONG),
        "alone": alone["samples_per_s"],
        "beside": long["samples_per_s"],
    }


def _run(robot: str, scenario: str, duration: float, watched: bool) -> dict[str, float]:
    """Run a loop, and give the processor times of plant and monitor [s], what was heard, and the speed."""
    with tempfile.TemporaryDirectory() as scratch:
        file = Path(scratch) / "run.yaml"
        file.write_text(json.dumps({**load_scenario(scenario).settings(), "duration": duration}))
        reports = {name: Path(scratch) / f"{name}.json" for name in ("plant", "gap_monitor")}
        values = [f"scenario:={file}", "observers:=0"]
        started = [_start(name, values) for name in ("controller", "feedforward")]
        if watched:
            started.append(_start("gap_monitor", ["model:=" + robot, f"report_file:={reports['gap_monitor']}"]))
        time.sleep(SETTLE)
        before = _used(started[-1].pid)
        plant = _start("plant", [*values, f"report_file:={reports['plant']}"])
        usage = os.wait4(plant.pid, 0)[2]
        time.sleep(3.0)
        monitor = _used(started[-1].pid) - before
        for one in started:
            one.send_signal(signal.SIGINT)
        for one in started:
            one.wait(60.0)
        speed = json.loads(reports["plant"].read_text())["figures"]["samples_per_s"]
        found = {"plant": usage.ru_utime + usage.ru_stime, "samples_per_s": speed}
        if watched:
            figures = json.loads(reports["gap_monitor"].read_text())["figures"]
            found |= {"monitor": monitor, "heard": figures["states"], "computing": figures["processor_time_s"]}
        return found


def _start(node: str, values: list[str]) -> subprocess.Popen[bytes]:
    arguments = [word for value in values for word in ("-p", value)]
    environment = {**os.environ, "ROS_DOMAIN_ID": "87", "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    command = [sys.executable, "-m", f"flexros_nodes.{node}", "--ros-args", *arguments]
    return subprocess.Popen(command, env=environment)  # noqa: S603


def _used(process: int) -> float:
    """Give the processor time of a process so far [s]."""
    fields = Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / TICK
