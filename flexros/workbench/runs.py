"""Runs of scenarios, and their analysis."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from flexros.analysis.run_analysis import Analysis, analyse
from flexros.errors import FlexrosError, InputError, unknown_name
from flexros.logs.reader import read_log
from flexros.scenario import transports
from flexros.scenario.scenario import Scenario, load_scenario
from flexros.workbench.given import log_of, robot_of

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    import pandas as pd
    import plotly.graph_objects as go

    from flexros.logs.time_series import Log
    from flexros.robot import Robot
    from flexros.scenario.transports import RunResult
    from flexros.workbench.given import GivenLog, GivenModel

TRANSPORTS = ("direct", "ros")


@dataclass(frozen=True, eq=False, repr=False)
class Run:
    """A run of a scenario with its log.

    Attributes:
        scenario: The scenario with all changes.
        result: Outcome: samples, times, figures, warnings.
        recorded: The log, where it was kept in memory; None where it is in a folder.
    """

    scenario: Scenario
    result: RunResult
    recorded: Log | None = None

    @property
    def name(self) -> str:
        """Name of the scenario."""
        return self.scenario.name

    @property
    def folder(self) -> Path | None:
        """Folder of the log; None for a run that was kept in memory."""
        return self.result.log_folder

    @cached_property
    def log(self) -> Log:
        """The log, read from its folder on first access.

        Raises:
            InputError: The run has left no log.
        """
        if self.recorded is not None:
            return self.recorded
        if self.folder is None:
            raise InputError(f"the run of {self.name} has no log: {self.result.message}; run it again")
        return read_log(self.folder)

    @cached_property
    def analysis(self) -> Analysis:
        """Path error, tracking, timing; frequency responses of an identification experiment."""
        return analyze(self)

    def to_pandas(self, topic: str = "") -> pd.DataFrame:
        """Return the log as a table, see `Log.to_pandas`."""
        return self.log.to_pandas(topic)

    def plot(self) -> go.Figure:
        """Draw the signals of the log, see `Log.plot`."""
        return self.log.plot()

    def __repr__(self) -> str:
        where = f"in {self.folder}" if self.folder is not None else "in memory"
        return f"<Run of {self.name}: {self.result.samples} samples, {self.result.simulated_time:.6g} s, {where}>"

    def _repr_html_(self) -> str:
        from flexros.report.base import Paragraph, TextTable
        from flexros.report.notebook import notebook_html
        from flexros.report.number_text import number

        result = self.result
        rows = (
            ("robot", self.scenario.robot),
            ("effects in the plant", ", ".join(self.scenario.plant.effects) or "none"),
            ("transport", result.transport),
            ("samples", str(result.samples)),
            ("simulated time", f"{number(result.simulated_time)} s"),
            ("wall time", f"{number(result.wall_time, 3)} s"),
            ("log", str(self.folder) if self.folder is not None else "in memory"),
        )
        notes = [Paragraph(text, "warning") for text in (result.message, *result.warnings) if text]
        return notebook_html(f"Run of {self.name}", (TextTable(("", ""), rows, "", left=2), *notes))


def run(
    scenario: Scenario | str | Path,
    *,
    model: str | Path | None = None,
    effects: Sequence[str] = (),
    settings: Mapping[str, Any] | None = None,
    seed: int | None = None,
    out: str | Path | None = None,
    transport: str = "direct",
    progress: Callable[[int, int], None] | None = None,
) -> Run:
    """Run a scenario: controller, feedforward and plant in closed loop.

    Args:
        scenario: Built-in name, path of a scenario file, or a scenario.
        model: Robot instead of the scenario's: built-in name, or path of a robot file or of a patch.
        effects: Effects in the plant, each as NAME@LOCATION:parameter=value,..., e.g.
            "coulomb_friction@motor_1:level=0.05" (Nm); after those of the scenario.
        settings: Other keys of the scenario with dots, e.g. {"sample_time": 0.001, "plant.values.body_3.mass": 190}.
        seed: Seed of noise and random disturbances; default: that of the scenario.
        out: Folder of the log (rosbag2 with MCAP); it must not exist. Default: the log is kept in memory, which the
            transport "ros" does not allow.
        transport: "direct", in this process, or "ros", over topics; both give the same samples.
        progress: Called with the number of samples simulated and the number of all, by the transport "direct".

    Returns:
        The run with its log; `analysis` evaluates it.

    Raises:
        InputError: Something given is unknown or not allowed.
        RunError: The state diverged, or the run aborted.
    """
    chosen = _changed(scenario, model, effects, settings or {}, seed)
    if transport not in TRANSPORTS:
        raise unknown_name("transport", transport, TRANSPORTS)
    if transport == "direct" and out is None:
        return _in_memory(chosen, progress)
    if out is None:
        raise InputError(
            "transport 'ros' records into a folder, but none was given; give one that does not exist", "out"
        )
    if transport == "direct":
        result = transports.run_direct(chosen, Path(out), progress)
    else:
        result = transports.run_ros(chosen, Path(out))
    result.require_complete(chosen.name)
    return Run(chosen, result)


def analyze(log: GivenLog, *, model: GivenModel | None = None, label: str | None = None) -> Analysis:
    """Analyse a run: path error, tracking of the motors, timing, and frequency responses of periodic runs.

    Args:
        log: A log, a run, or the path of a rosbag2 folder or of an .mcap file.
        model: The robot of the run, for its torque limits; default: the one that the log names, where it is known.
        label: Name of the run in tables and pictures; default: its scenario.

    Returns:
        The analysis; what the log does not contain is None there and named in its warnings.

    Raises:
        InputError: There is no such log, or it contradicts itself or the robot.
    """
    read = log_of(log)
    return analyse(read, robot=_robot_of_run(read) if model is None else robot_of(model), label=label)


def _changed(
    given: Scenario | str | Path,
    model: str | Path | None,
    effects: Sequence[str],
    settings: Mapping[str, Any],
    seed: int | None,
) -> Scenario:
    chosen = given if isinstance(given, Scenario) else load_scenario(given)
    if model is not None and not isinstance(model, (str, Path)):
        raise InputError(
            f"the model of a run is a {type(model).__name__}, allowed is the name or the path of a robot, which the "
            "scenario states in the log; write it to a file, or change values by settings",
            "model",
        )
    if isinstance(effects, str):
        raise InputError(f"the effects are the text '{effects}', allowed is a list of such texts; put it in brackets")
    return chosen.with_choices(None if model is None else str(model), settings, effects, seed)


def _in_memory(scenario: Scenario, progress: Callable[[int, int], None] | None) -> Run:
    import time

    from flexros.scenario.closed_loop import closed_loop
    from flexros.scenario.experiment import Experiment

    experiment = Experiment.prepare(scenario)
    total = experiment.n_samples
    begin = time.perf_counter()
    log = closed_loop(experiment, None if progress is None else lambda done: progress(done, total))
    wall = time.perf_counter() - begin
    result = transports.RunResult(
        exit_code=0,
        message="",
        transport="direct",
        log_folder=None,
        samples=total,
        simulated_time=total * experiment.sample_time,
        wall_time=wall,
        warnings=experiment.warnings,
    )
    return Run(scenario, result, log)


def _robot_of_run(log: Log) -> Robot | None:
    """Load the robot of a run; None where the provenance names none that can be loaded."""
    scenario = log.provenance.get("scenario")
    name = scenario.get("robot") if isinstance(scenario, dict) else None
    try:
        return robot_of(name) if isinstance(name, str) else None
    except FlexrosError:
        return None
