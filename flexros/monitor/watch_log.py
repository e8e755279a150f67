"""The monitor applied to a log, with the same figures as on the running robot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.monitor.alarms import Level
from flexros.monitor.gap_monitor import RECENT, GapMonitor
from flexros.monitor.statement import robot_sentence
from flexros.record.joint_columns import motor_columns

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.arrays import FloatArray
    from flexros.logs.time_series import Log
    from flexros.monitor.gap_monitor import MonitorReading
    from flexros.monitor.watch import WindowResult

CHUNK = 2000
"""Messages passed to the monitor at once (chosen); the figures do not depend on it."""


@dataclass(frozen=True, eq=False)
class Episode:
    """An alarm.

    Attributes:
        stamp: Stamp of the last window when the alarm was raised [ns].
        since: Stamp of the beginning of the gap [ns].
        sentence: Statement at the end of the episode or of the log.
        joint: Joint of the location, "tool" for the tool; empty where it is undetermined.
        kind: Kind of the location; empty where it is undetermined.
    """

    stamp: int
    since: int
    sentence: str
    joint: str
    kind: str


@dataclass(frozen=True, eq=False)
class WatchedLog:
    """Result of the monitor over a log.

    Attributes:
        results: Results of the windows.
        reading: Reading at the end.
        episodes: Alarms.
        warnings: What is doubtful, one sentence each.
    """

    results: tuple[WindowResult, ...]
    reading: MonitorReading
    episodes: tuple[Episode, ...]
    warnings: tuple[str, ...]

    @property
    def values(self) -> FloatArray:
        """Mean squares of innovations, then of disturbance torques, over those of noise [1], shape (windows, 2 M)."""
        return np.array([np.concatenate([result.innovation, result.disturbance]) for result in self.results])

    @property
    def motion(self) -> FloatArray:
        """Mean squares of torques, speeds and accelerations [SI], shape (windows, 3 M)."""
        return np.array([result.motion for result in self.results])


def watch_log(
    log: Log, monitor: GapMonitor, *, name: str, progress: Callable[[int, int], None] | None = None
) -> WatchedLog:
    """Apply a monitor to a log.

    Args:
        log: The log.
        monitor: A new monitor.
        name: Name of the log, for messages.
        progress: Called with the number of states processed and their total.

    Raises:
        InputError: The log lacks positions or commands, or no window could be evaluated.
    """
    states, commands = log.joint_states, log.joint_commands
    if states.position is None or commands is None or commands.effort is None:
        lacking = "positions in joint_states" if states.position is None else "torques in joint_commands"
        raise InputError(f"{name} has no {lacking}, without which the observer model cannot run; record them")
    warnings: list[str] = []
    robot = monitor.robot
    motors, owner = robot.joint_names, f"robot {robot.name}"
    columns = motor_columns(states.names, motors, f"{name}: joint_states", warnings, owner=owner)
    ordered = tuple(states.names[column] for column in columns)
    position = states.position[:, columns]
    columns = motor_columns(commands.names, motors, f"{name}: joint_commands", warnings, owner=owner, states=ordered)
    effort = commands.effort[:, columns]
    results: list[WindowResult] = []
    episodes: list[Episode] = []
    done = 0
    for first in range(0, len(states.stamp), CHUNK):
        rows = slice(first, first + CHUNK)
        monitor.add_states(states.stamp[rows], position[rows])
        last = len(commands.stamp)
        if rows.stop < len(states.stamp):
            last = int(np.searchsorted(commands.stamp, states.stamp[rows.stop - 1], side="right"))
        monitor.add_commands(commands.stamp[done:last], effort[done:last])
        done = last
        for result in monitor.each():
            if result is not None:
                results.append(result)
            if monitor.level is Level.ALARM and (monitor.alarms > len(episodes) or not monitor.windows % RECENT):
                _note(episodes, monitor)
        if progress is not None:
            progress(min(rows.stop, len(states.stamp)), len(states.stamp))
    if not results and not episodes:
        raise InputError(f"{name}: {_why_nothing(monitor)}")
    return WatchedLog(tuple(results), monitor.reading(), tuple(episodes), tuple(dict.fromkeys(warnings)))


def _why_nothing(monitor: GapMonitor) -> str:
    counts = monitor.counts
    return (
        f"no window could be evaluated: {counts.states} states and {counts.commands} commands make {monitor.settled} "
        f"windows of 0.1 s in which the observer was still converging, and {counts.lost_windows} with missing samples; "
        "give a log of ten seconds or more"
    )


def _note(episodes: list[Episode], monitor: GapMonitor) -> None:
    """Add an episode for a new alarm, and update the last one."""
    reading = monitor.reading()
    location = reading.locations[0].location if reading.locations else None
    if monitor.alarms > len(episodes):
        since = min(motor.alarm.since for motor in reading.motors if motor.alarm.level is Level.ALARM)
        episodes.append(Episode(reading.stamp, since, robot_sentence(reading), "", ""))
    if location is not None:
        begun = episodes[-1]
        episodes[-1] = Episode(begun.stamp, begun.since, robot_sentence(reading), location.joint, location.kind)
