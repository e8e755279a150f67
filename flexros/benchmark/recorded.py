"""Measures of a recorded run of the nominal model, e.g. with a controller that is a node of its own."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from flexros.benchmark.disturbances import DURATION
from flexros.benchmark.measures import measures_of_run
from flexros.benchmark.models import NOMINAL, RULES
from flexros.errors import InputError
from flexros.logs.reader import read_log
from flexros.robot import load_robot

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.benchmark.measures import Measures

SCENARIO = "feedback_benchmark"
"""Scenario of the nominal model."""


def is_recording(text: str) -> bool:
    """Return whether an argument names a log instead of a controller."""
    path = Path(text)
    return path.is_dir() or path.suffix == ".mcap"


@dataclass(frozen=True, eq=False)
class RecordedRun:
    """A recorded run of the nominal model.

    Attributes:
        name: Name of the log.
        deflection: Tool deflection [mm], shape (n,).
        command: Torque command [Nm], shape (n,).
        sample_time: Time between two samples [s].
    """

    name: str
    deflection: FloatArray
    command: FloatArray
    sample_time: float

    @property
    def measures(self) -> Measures:
        """Measures of the nominal model, with the seed of the run."""
        return measures_of_run(self.deflection, self.command, RULES[NOMINAL].band, self.sample_time)


def recorded_run(path: Path) -> RecordedRun:
    """Read a log of the scenario `feedback_benchmark`.

    Args:
        path: Log folder or .mcap file, with the topics joint_commands and tool_pose at every sample.

    Raises:
        InputError: The log is not one of this scenario, or it is not complete.
    """
    log = read_log(path)
    sample_time = load_robot("four_mass").sample_time
    needed = round(DURATION / sample_time) + 1
    scenario = log.provenance.get("scenario")
    name = scenario.get("robot") if isinstance(scenario, dict) else None
    if name is not None and name != "four_mass":
        raise InputError(f"{path}: the run is of robot {name}, needed is the scenario {SCENARIO}; run that one")
    commands = None if log.joint_commands is None else log.joint_commands.effort
    if commands is None or log.tool_pose is None:
        raise InputError(f"{path}: joint_commands or tool_pose was not recorded; record both")
    counts = {"joint_commands": len(commands), "tool_pose": len(log.tool_pose.position)}
    for topic, count in counts.items():
        if count != needed:
            raise InputError(
                f"{path}: {topic} has {count} samples, the scenario {SCENARIO} has {needed}; run it to its end"
            )
    return RecordedRun(path.name, 1e3 * log.tool_pose.position[:, 0], commands[:, 0], sample_time)
