"""What the gap monitor costs beside a robot at 2 kHz: nodes as processes, their processor time read from /proc."""

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

TIME = 30.0
"""Time that is measured [s]."""
SETTLE = 12.0
"""Time before: the nodes find each other, and the twin finds the robot [s]."""
SCENARIOS = {"e12": "circle_dae", "six_axis": "six_axis_moves"}
TICK = os.sysconf("SC_CLK_TCK")


def measured_load() -> dict[str, Any]:
    """Measure all robots."""
    rows = [_measured(robot, scenario) for robot, scenario in SCENARIOS.items()]
    load = os.getloadavg()[0]
    machine = f"{os.cpu_count()} processors; mean number of other runnable tasks during the last minute: {load:.1f}."
    return {"time": TIME, "machine": machine, "rows": rows}


def _measured(robot: str, scenario: str) -> dict[str, Any]:
    with tempfile.TemporaryDirectory() as scratch:
        file = Path(scratch) / "long.yaml"
        file.write_text(json.dumps({**load_scenario(scenario).settings(), "duration": 2 * (TIME + SETTLE)}))
        report = Path(scratch) / "monitor.json"
        nodes = {
            "gap_monitor": ["model:=" + robot, f"report_file:={report}"],
            "controller": [f"scenario:={file}", "observers:=0"],
            "feedforward": [f"scenario:={file}", "observers:=0"],
            "plant": [f"scenario:={file}", "observers:=0", "real_time:=true"],
        }
        started = {name: _start(name, values) for name, values in nodes.items()}
        try:
            time.sleep(SETTLE)
            before, begun = {name: _used(one.pid) for name, one in started.items()}, time.perf_counter()
            time.sleep(TIME)
            wall = time.perf_counter() - begun
            share = {name: (_used(one.pid) - before[name]) / wall for name, one in started.items()}
        finally:
            for one in started.values():
                one.send_signal(signal.SIGINT)
            for one in started.values():
                one.wait(30.0)
        figures = json.loads(report.read_text())["figures"]
    watched = figures["windows"] + figures["settling_windows"]
    return {
        "robot": robot,
        **share,
        "seen": watched / max(watched + figures["lost_windows"], 1),
        "computing": figures["processor_time_s"] / max(0.1 * watched, 0.1),
    }


def _start(node: str, values: list[str]) -> subprocess.Popen[bytes]:
    arguments = [word for value in values for word in ("-p", value)]
    environment = {**os.environ, "ROS_DOMAIN_ID": "87", "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    command = [sys.executable, "-m", f"flexros_nodes.{node}", "--ros-args", *arguments]
    return subprocess.Popen(command, env=environment)  # noqa: S603


def _used(process: int) -> float:
    """Give the processor time of a process so far [s]."""
    fields = Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / TICK
