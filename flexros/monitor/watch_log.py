"""The monitor over a log: the same figures as beside the robot, at once."""

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
    from flexros.monitor.watch import Missed

CHUNK = 2000
"""Messages that are given to the monitor at once (chosen); the figures do not depend on it."""


@dataclass(frozen=True, eq=False)
class Episode:
    """An alarm, from its beginning.

    Attributes:
        stamp: Stamp up to which the monitor had watched when it told [ns].
        since: Stamp from which on the gap shows [ns].
        sentence: What it said, at the end of the episode or of the log, when most is known.
        joint: Joint that it named, "tool" for the tool; empty where it named none.
        kind: Kind of the place; empty where it named none.
    """

    stamp: int
    since: int
    sentence: str
    joint: str
    kind: str


@dataclass(frozen=True, eq=False)
class WatchedLog:
    """What the monitor found in a log.

    Attributes:
        missed: What the twin missed, window by window.
        reading: Reading at the end.
        episodes: Its alarms.
        warnings: What was noticed, a sentence each.
    """

    missed: tuple[Missed, ...]
    reading: MonitorReading
    episodes: tuple[Episode, ...]
    warnings: tuple[str, ...]

    @property
    def values(self) -> FloatArray:
        """Mean squares of all windows over those of noise, sudden parts then missing torques, shape (windows, 2 M)."""
        return np.array([np.concatenate([one.sudden, one.slow]) for one in self.missed])

    @property
    def motion(self) -> FloatArray:
        """What the robot did in them: mean squares of torques, speeds and accelerations [SI], shape (windows, 3 M)."""
        return np.array([one.motion for one in self.missed])


def watch_log(
    log: Log, monitor: GapMonitor, *, name: str, progress: Callable[[int, int], None] | None = None
) -> WatchedLog:
    """Lead a log through a monitor.

    Args:
        log: The log.
        monitor: The monitor, fresh.
        name: Name of the log, for messages.
        progress: Called with the number of states done and of all, now and then.

    Raises:
        InputError: The log lacks positions or commands, or nothing of it could be watched.
    """
    states, commands = log.joint_states, log.joint_commands
    if states.position is None or commands is None or commands.effort is None:
        lacking = "positions in joint_states" if states.position is None else "torques in joint_commands"
        raise InputError(f"{name} has no {lacking}, without which the model cannot run beside the robot; record them")
    warnings: list[str] = []
    robot = monitor.robot
    motors, owner = robot.joint_names, f"robot {robot.name}"
    columns = motor_columns(states.names, motors, f"{name}: joint_states", warnings, owner=owner)
    ordered = tuple(states.names[column] for column in columns)
    position = states.position[:, columns]
    columns = motor_columns(commands.names, motors, f"{name}: joint_commands", warnings, owner=owner, states=ordered)
    effort = commands.effort[:, columns]
    missed: list[Missed] = []
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
        for one in monitor.each():
            if one is not None:
                missed.append(one)
            if monitor.level is Level.ALARM and (monitor.alarms > len(episodes) or not monitor.windows % RECENT):
                _note(episodes, monitor)
        if progress is not None:
            progress(min(rows.stop, len(states.stamp)), len(states.stamp))
    if not missed and not episodes:
        raise InputError(f"{name}: {_why_nothing(monitor)}")
    return WatchedLog(tuple(missed), monitor.reading(), tuple(episodes), tuple(dict.fromkeys(warnings)))


def _why_nothing(monitor: GapMonitor) -> str:
    counts = monitor.counts
    return (
        f"nothing could be watched: {counts.states} states and {counts.commands} commands make "
        f"{monitor.settled} windows of 0.1 s in which the model was still finding the robot, and {counts.lost_windows} "
        "that lack samples; give a log of ten seconds or more"
    )


def _note(episodes: list[Episode], monitor: GapMonitor) -> None:
    """Begin an episode with every alarm, and bring the last one up to date."""
    reading = monitor.reading()
    first = reading.suspected[0].place if reading.suspected else None
    if monitor.alarms > len(episodes):
        since = min(motor.alarm.since for motor in reading.motors if motor.alarm.level is Level.ALARM)
        episodes.append(Episode(reading.stamp, since, robot_sentence(reading), "", ""))
    if first is not None:
        begun = episodes[-1]
        episodes[-1] = Episode(begun.stamp, begun.since, robot_sentence(reading), first.joint, first.kind)
