"""Plan of a run of all nodes, and its summary."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING
from uuid import uuid4

from flexros.config.topics import load_topics
from flexros.errors import INTERNAL_ERROR, INTERRUPTED, RunError
from flexros_nodes.protocol.real_time.precise_timing import PRIORITY
from flexros_nodes.protocol.real_time.schedule import PeriodStatistics

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from flexros.scenario.scenario import Scenario
    from flexros_nodes.protocol.node_report import NodeReport
    from flexros_nodes.protocol.parameters import Value

LEADERS = ("feedforward", "identification")
"""Nodes that stream the reference; each run has one of them."""

NODES = ("recorder", *LEADERS, "controller", "plant")
"""Nodes in the order of bring-up; shutdown is in reverse."""

SHUTDOWN_TIMEOUT = 20.0
"""Longest time for a node in a process of its own to shut down [s], chosen: under load a recorder takes seconds to
close its log."""

IN_REAL_TIME: dict[str, dict[str, Value]] = {
    "plant": {"priority": PRIORITY},
    "controller": {"priority": PRIORITY},
    **{leader: {"priority": PRIORITY // 2} for leader in LEADERS},
    "recorder": {"priority": PRIORITY // 2, "niceness": 10},
}
"""Priorities of the nodes in processes of their own in real time, chosen.

Other processes of the machine must delay neither reference nor log. Where the system grants no priority, the recorder
yields to the loop by its niceness: it has time until the end.
"""


REAL_TIME_STREAM: dict[str, Value] = {"chunk_duration": 0.25, "lead": 1.0}
"""Parameters of the reference stream in real time, chosen: a chunk of any length takes most of a cycle."""


def leader_of(scenario: Scenario) -> str:
    """Return the node that streams the reference of a scenario."""
    return "feedforward" if scenario.identification is None else "identification"


def new_identity() -> str:
    """Return an identity that no other run has."""
    return uuid4().hex


def nodes_led_by(leader: str) -> tuple[str, ...]:
    """Return the nodes of a run in the order of bring-up: all but the other leaders."""
    return tuple(name for name in NODES if name == leader or name not in LEADERS)


@dataclass(frozen=True)
class RunPlan:
    """Plan of a run.

    Attributes:
        scenario: Built-in scenario, or path of a scenario file.
        folder: Folder of the log; None records nothing.
        parameters: Parameter values by node, in addition to those that follow from the plan.
        leader: Node that streams the reference: feedforward or identification.
        run: Identity of the run, by which its nodes refuse those of another run; see `new_identity`.
    """

    scenario: str
    folder: Path | None
    parameters: Mapping[str, Mapping[str, Value]]
    leader: str = "feedforward"
    run: str = ""

    @property
    def nodes(self) -> tuple[str, ...]:
        """Nodes of the run in the order of bring-up."""
        return tuple(name for name in nodes_led_by(self.leader) if name != "recorder" or self.folder is not None)

    def values(self, node: str) -> dict[str, Value]:
        """Return the parameter values of a node."""
        values: dict[str, Value] = {"scenario": self.scenario, "autostart": False, "run": self.run}
        values["observers"] = 0 if self.folder is None else 1
        if node in LEADERS and self.real_time:
            values |= REAL_TIME_STREAM
        if node == "recorder":
            values |= {"folder": str(self.folder), "real_time": self.real_time}
        return {**values, **self.parameters.get(node, {})}

    def process_values(self, node: str) -> dict[str, Value]:
        """Return the parameter values of a node in a process of its own."""
        priorities = IN_REAL_TIME.get(node, {}) if self.real_time else {}
        return {**priorities, **self.values(node)}

    @property
    def real_time(self) -> bool:
        """Whether the plant paces the loop by the wall clock."""
        return bool(self.parameters.get("plant", {}).get("real_time", False))


@dataclass(frozen=True)
class RunSummary:
    """Result of a run.

    Attributes:
        exit_code: 0 complete, 3 aborted, 130 interrupted.
        message: Error message in one sentence; empty when the plan was completed.
        log_folder: Folder of the log, None if there is no log.
        layout: "composed" or "processes".
        samples: Number of samples of the loop.
        simulated_time: Simulated time of the run [s].
        wall_time: Wall-clock time of the run [s].
        samples_per_second: Speed of the loop [1/s].
        resends: Repeated states.
        dropped: Messages dropped on purpose.
        missing: Sent samples that are missing in the log, over all topics.
        unseen: Samples that never reached the controller; they have neither command nor reference.
        timing: Period and lateness of a real-time run by name, and the share of late cycles of a bare loop measured
            after it; else empty.
        reports: Reports by node, of nodes that wrote one.
        domain_id: ROS domain of the run, in which other nodes can join; -1 if unknown.
    """

    exit_code: int
    message: str
    log_folder: Path | None
    layout: str
    samples: int
    simulated_time: float
    wall_time: float
    samples_per_second: float
    resends: int
    dropped: int
    missing: int
    unseen: int
    timing: Mapping[str, float] = field(default_factory=dict)
    reports: Mapping[str, NodeReport] = field(default_factory=dict)
    domain_id: int = -1


_TIMING = (*(field.name for field in fields(PeriodStatistics)), "missed_commands", "real_time_priority")


def summarise(
    reports: Mapping[str, NodeReport],
    folder: Path | None,
    layout: str,
    *,
    interrupted: bool,
    deaths: tuple[str, ...] = (),
) -> RunSummary:
    """Summarise a run.

    Args:
        reports: Reports by node, of nodes that wrote one.
        folder: Folder of the log.
        layout: "composed" or "processes".
        interrupted: Whether termination was requested.
        deaths: How processes died.

    Returns:
        The summary; its exit code is the largest of all nodes.
    """
    failed = [report for report in reports.values() if report.exit_code]
    exit_code = max((report.exit_code for report in failed), default=3 if deaths else 0)
    # a failed partner makes the plant abort: its message goes first
    failed.sort(key=lambda report: report.node == "plant")
    message = "; ".join((*deaths, *(report.message for report in failed)))
    if interrupted and not exit_code:
        exit_code, message = INTERRUPTED, "interrupted"
    if not exit_code:
        message = _stopped(reports)
    plant = reports["plant"].figures if "plant" in reports else {}
    recorder = reports["recorder"].figures if "recorder" in reports else {}
    recorded = int(recorder.get("joint_states.messages", 0))
    unseen = int(reports["controller"].figures.get("missed_states", 0)) if "controller" in reports else 0
    log = folder if folder is not None and folder.is_dir() else None
    if exit_code in (RunError.exit_code, INTERNAL_ERROR, INTERRUPTED):
        message += _state_of_log(log, reports.get("recorder"), recorded, wanted=folder is not None)
    return RunSummary(
        exit_code=exit_code,
        message=message,
        log_folder=log,
        layout=layout,
        samples=int(plant.get("samples", recorded)),
        simulated_time=plant.get("simulated_time_s", 0.0),
        wall_time=plant.get("wall_time_s", 0.0),
        samples_per_second=plant.get("samples_per_s", 0.0),
        resends=int(plant.get("resends", 0)),
        dropped=int(sum(report.figures.get("dropped_on_purpose", 0) for report in reports.values())),
        missing=_missing(recorder, unseen),
        unseen=unseen,
        timing={name: plant[name] for name in _TIMING if name in plant},
        reports=reports,
    )


def _missing(recorder: Mapping[str, float], unseen: int) -> int:
    """Count the samples missing in the log, except those never sent because the controller did not receive them."""
    missing = 0
    for name, row in load_topics().items():
        never_sent = unseen if row.producer == "controller" else 0
        missing += max(0, int(recorder.get(f"{name}.missing", 0)) - never_sent)
    return missing


def _stopped(reports: Mapping[str, NodeReport]) -> str:
    """Return that the user stopped an identification; empty if not."""
    figures = reports["identification"].figures if "identification" in reports else {}
    if figures.get("stopped_at_sample", -1) < 0:
        return ""
    return (
        f"stopped by the service stop at sample {figures['stopped_at_sample']:.0f}: {figures['completed']:.0f} of "
        f"{figures['planned']:.0f} experiments are complete"
    )


def _state_of_log(log: Path | None, recorder: NodeReport | None, recorded: int, *, wanted: bool) -> str:
    """Return the state of the log of an aborted run; empty where the recorder itself failed and reports it."""
    if not wanted:
        return "; no recording was requested"
    if recorder is not None and recorder.exit_code:
        return ""
    if log is None:
        return "; there is no log"
    if recorder is None:  # killed: the log is readable, its length is unknown
        return f"; analyse {log} to see how far the log reaches"
    return "; the log is valid up to that point" if recorded else "; the log holds no samples"
