"""Expected output of nodes without a log of their own; `python -m tests.golden.streams` rewrites the golden files."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

from flexros.atomic_file import write_whole
from flexros.effects.patching.patched_robot import load_model
from flexros.monitor.gap_monitor import GapMonitor, MonitorReading
from flexros.monitor.statement import motor_sentence, motor_values, robot_sentence, robot_values
from flexros.monitor.watch_log import watch_log
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario
from tests.nodes.conftest import identification_settings

FILE = Path(__file__).parent / "streams.json"
MESSAGES = Path(__file__).parent / "messages.txt"
"""Sentences of the monitor, one a line: a changed wording is reviewed as a diff of this file."""
EVERY = 60
"""Decimation of the reference."""


def identification_reference(folder: Path) -> list[list[float]]:
    """Return stamp [s], position, velocity and torque of the reference that node identification streams."""
    file = folder / "identify.yaml"
    file.write_text(json.dumps(identification_settings()))
    reference = closed_loop(Experiment.prepare(load_scenario(file))).joint_reference
    assert reference is not None
    columns = (reference.stamp * 1e-9, reference.position[:, 0], reference.velocity[:, 0], reference.effort[:, 0])
    return [[float(column[k]) for column in columns] for k in range(0, len(reference.stamp), EVERY)]


@cache
def monitor_reading() -> MonitorReading:
    """Return the reading of the gap monitor at the end of a log with friction."""
    changes = {
        "robot": "elbow",
        "diagnosis.length": 12,
        "seed": 31,
        "plant.effects": ["coulomb_friction@motor_2:level=1"],
    }
    log = closed_loop(Experiment.prepare(load_scenario("diagnosis").with_values(changes, "golden")))
    monitor = GapMonitor(load_model("elbow"))
    watch_log(log, monitor, name="golden")
    return monitor.reading()


def monitor_statuses() -> list[dict[str, Any]]:
    """Return the values of node gap_monitor, of the robot and of each motor."""
    reading = monitor_reading()
    return [robot_values(reading), *(motor_values(motor) for motor in reading.motors)]


def monitor_messages() -> list[str]:
    """Return the sentences of node gap_monitor, of the robot and of each motor."""
    reading = monitor_reading()
    return [robot_sentence(reading), *(motor_sentence(motor, "Nm") for motor in reading.motors)]


def main() -> None:
    """Write the files."""
    from tempfile import TemporaryDirectory

    with TemporaryDirectory() as folder:
        found = {
            "identification_reference": identification_reference(Path(folder)),
            "monitor_statuses": monitor_statuses(),
        }
    write_whole(FILE, json.dumps(found, indent=1) + "\n")
    write_whole(MESSAGES, "\n".join(monitor_messages()) + "\n")


if __name__ == "__main__":
    main()
