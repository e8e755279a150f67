"""What nodes without a log of their own have to give; `python -m tests.golden.streams` writes streams.json anew."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from flexros.effects.patching.patched_robot import load_model
from flexros.monitor.gap_monitor import GapMonitor
from flexros.monitor.statement import motor_sentence, motor_values, robot_sentence, robot_values
from flexros.monitor.watch_log import watch_log
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario
from flexros.whole_file import write_whole
from tests.nodes.conftest import identification_settings

FILE = Path(__file__).parent / "streams.json"
EVERY = 60
"""Of so many samples one is kept."""


def identification_reference(folder: Path) -> list[list[float]]:
    """Give stamp [s], position, velocity and torque of the reference that node identification streams."""
    file = folder / "identify.yaml"
    file.write_text(json.dumps(identification_settings()))
    reference = closed_loop(Experiment.prepare(load_scenario(file))).joint_reference
    assert reference is not None
    columns = (reference.stamp * 1e-9, reference.position[:, 0], reference.velocity[:, 0], reference.effort[:, 0])
    return [[float(column[k]) for column in columns] for k in range(0, len(reference.stamp), EVERY)]


def monitor_statuses() -> list[dict[str, Any]]:
    """Give what node gap_monitor says at the end of a log with friction: of the robot, and of each motor."""
    changes = {
        "robot": "elbow",
        "diagnosis.length": 12,
        "seed": 31,
        "plant.effects": ["coulomb_friction@motor_2:level=1"],
    }
    log = closed_loop(Experiment.prepare(load_scenario("diagnosis").with_values(changes, "golden")))
    monitor = GapMonitor(load_model("elbow"))
    watch_log(log, monitor, name="golden")
    reading = monitor.reading()
    motors = [{"says": motor_sentence(motor, "Nm"), **motor_values(motor)} for motor in reading.motors]
    return [{"says": robot_sentence(reading), **robot_values(reading)}, *motors]


def main() -> None:
    """Write the file."""
    from tempfile import TemporaryDirectory

    with TemporaryDirectory() as folder:
        found = {
            "identification_reference": identification_reference(Path(folder)),
            "monitor_statuses": monitor_statuses(),
        }
    write_whole(FILE, json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main()
