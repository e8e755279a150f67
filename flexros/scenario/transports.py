"""Transports of a run: in this process, or over ROS 2 topics by the installed nodes."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from functools import partial
from importlib import metadata
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from flexros.errors import INTERRUPTED, InputError, InterruptedRunError, RunError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from contextlib import AbstractContextManager
    from pathlib import Path

    from flexros.scenario.scenario import Scenario

GROUP = "flexros.transports"
"""Entry points that run a scenario; the package of the nodes announces "ros" there."""


@dataclass(frozen=True)
class RunResult:
    """Outcome of a run, the same for every transport.

    Attributes:
        exit_code: 0 done, 3 aborted, 130 interrupted.
        message: What happened, one sentence; empty when done.
        transport: "direct", or "ros" with its layout.
        log_folder: Folder of the log.
        samples: Samples of the loop.
        simulated_time: Number of samples times the sample time [s].
        wall_time: Time that the loop took [s]; in-process with feedforward and compilation.
        figures: Further figures by name: resends, messages dropped on purpose, missing samples, timing.
        warnings: Known effects that the feedforward cannot compensate, a sentence each.
    """

    exit_code: int
    message: str
    transport: str
    log_folder: Path | None
    samples: int
    simulated_time: float
    wall_time: float
    figures: Mapping[str, float] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """Return the figures for JSON; times in seconds."""
        return {
            "exit_code": self.exit_code,
            "message": self.message,
            "transport": self.transport,
            "log": None if self.log_folder is None else str(self.log_folder),
            "samples": self.samples,
            "simulated_time_s": self.simulated_time,
            "wall_time_s": self.wall_time,
            **self.figures,
            **({"warnings": list(self.warnings)} if self.warnings else {}),
        }

    def require_complete(self, name: str = "") -> None:
        """Raise an error unless the run reached its end.

        Args:
            name: Name of the run, put before the message where it is given.

        Raises:
            InterruptedRunError: The run was interrupted.
            RunError: The run aborted.
        """
        if self.exit_code:
            error = InterruptedRunError if self.exit_code == INTERRUPTED else RunError
            raise error(f"{name}: {self.message}" if name else self.message)


def ros_runner() -> tuple[Callable[..., Any] | None, str]:
    """Find the runner of the nodes.

    Returns:
        The runner, or None and a sentence that says why there is none.
    """
    entries = [entry for entry in metadata.entry_points(group=GROUP) if entry.name == "ros"]
    if not entries:
        return None, "the ROS 2 nodes of FlexROS are not installed"
    if find_spec("rclpy") is None:
        return None, "no rclpy can be imported here (source ROS 2 Jazzy, or install the extra 'ros' on Linux x86_64)"
    try:
        runner: Callable[..., Any] = entries[0].load()
    except ImportError as error:
        return None, f"the ROS 2 nodes cannot be loaded ({error})"
    return runner, ""


def run_direct(scenario: Scenario, out: Path, progress: Callable[[int, int], None] | None = None) -> RunResult:
    """Run a scenario in this process and write its log.

    Args:
        scenario: The scenario.
        out: Folder of the log; it must not exist.
        progress: Called with the number of samples simulated and the number of all.

    Returns:
        The outcome; exit code 3 where the state diverged, the log is valid up to that point.

    Raises:
        InputError: Scenario or folder are not allowed.
        RunError: The log cannot be written.
    """
    from flexros.logs.write_log import write_log
    from flexros.scenario.closed_loop import DivergedRunError, closed_loop
    from flexros.scenario.experiment import Experiment

    _check_new(out)
    experiment = Experiment.prepare(scenario)
    report = None if progress is None else partial(_count, progress, experiment.n_samples)
    start, message = time.perf_counter(), ""
    try:
        log = closed_loop(experiment, progress=report)
    except DivergedRunError as error:
        log, message = error.log, f"{error}; the log up to there is {out}"
    wall = time.perf_counter() - start
    samples = len(log.joint_states.stamp)
    code = RunError.exit_code if message else 0
    simulated, warnings = samples * experiment.sample_time, experiment.warnings
    del experiment  # signals of a long run that its log does not need
    write_log(log, out)
    return RunResult(code, message, "direct", out, samples, simulated, wall, warnings=warnings)


def _count(progress: Callable[[int, int], None], total: int, done: int) -> None:
    progress(done, total)


def run_ros(
    scenario: Scenario,
    out: Path,
    layout: str = "composed",
    real_time: bool = False,
    parameters: Mapping[str, Mapping[str, Any]] | None = None,
    *,
    network: bool = False,
    beside: AbstractContextManager[object] | None = None,
) -> RunResult:
    """Run a scenario over ROS 2 topics.

    Args:
        scenario: The scenario.
        out: Folder of the log, to be made.
        layout: "composed" or "processes".
        real_time: Pace by the wall clock instead of lock-step.
        parameters: Node parameters, e.g. {"plant": {"drop_fraction": 0.01}}.
        network: Let nodes on other machines take part.
        beside: Entered before the nodes start and left after they ended, with the ROS domain of the run in the
            environment.

    Returns:
        The outcome.

    Raises:
        InputError: The nodes are not installed, or scenario, parameters or folder are not allowed.
    """
    from flexros.scenario.experiment import Experiment

    runner, why = ros_runner()
    if runner is None:
        raise InputError(f"transport 'ros' cannot be used: {why}; use 'direct'", "transport")
    _check_new(out)
    warnings = Experiment.prepare(scenario).warnings  # an error is reported once here, and not by each node
    summary = runner(scenario, out, layout, real_time=real_time, network=network, parameters=parameters, beside=beside)
    return RunResult(
        exit_code=summary.exit_code,
        message=summary.message,
        transport=f"ros, {summary.layout}",
        log_folder=summary.log_folder,
        samples=summary.samples,
        simulated_time=summary.simulated_time,
        wall_time=summary.wall_time,
        figures={
            "resends": summary.resends,
            "dropped_on_purpose": summary.dropped,
            "missing_in_log": summary.missing,
            "unseen_samples": summary.unseen,
            "samples_per_second": summary.samples_per_second,
            "ros_domain_id": summary.domain_id,
            **summary.timing,
        },
        warnings=warnings,
    )


def _check_new(folder: Path) -> None:
    """Refuse to write a log over something."""
    if folder.exists():
        raise InputError(f"the log folder {folder} exists already; give another one", "out")
