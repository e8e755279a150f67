"""Input of a replayed controller in addition to the measurements: the recorded reference in chunks, ahead of time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.logs.messages.joint_trajectory import JointTrajectoryChunk, serialise_joint_trajectory
from flexros.logs.reader import read_log
from flexros.logs.stamps import NANOSECONDS

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from flexros.arrays import FloatArray
    from flexros.logs.time_series import JointSeries

LEAD = NANOSECONDS // 2
"""Lead of a chunk before its first sample [ns], chosen as in the feedforward."""

CHUNK = 200
"""Samples in a chunk, chosen as in the feedforward at 2 kHz."""


@dataclass(frozen=True, eq=False)
class ReferenceChunk:
    """Samples of the reference.

    Attributes:
        log_time: Log time at which it is played [ns].
        last_stamp: Stamp of its last sample [ns].
        payload: Serialised JointTrajectory.
    """

    log_time: int
    last_stamp: int
    payload: bytes


@dataclass(frozen=True, eq=False)
class ControllerFeed:
    """Recorded reference and commands of a controller, with which its answers can be reproduced.

    Attributes:
        chunks: The reference that it used, in order.
        joint_names: Joints of the commands.
        commands: Recorded command by stamp [ns], in the order of `joint_names`; empty if none were recorded.
    """

    chunks: tuple[ReferenceChunk, ...]
    joint_names: tuple[str, ...]
    commands: Mapping[int, tuple[float, ...]]


def controller_feed(path: Path | str, namespace: str | None = None) -> ControllerFeed:
    """Read the reference and the commands of a log.

    Args:
        path: A rosbag2 folder or an .mcap file.
        namespace: Namespace of the topics; None if the log has only one.

    Raises:
        InputError: The log has no joint_states or no joint_reference with positions.
    """
    log = read_log(path, namespace)
    reference, commands = log.joint_reference, log.joint_commands
    if reference is None or reference.position is None:
        raise InputError(
            f"{path} has no positions on joint_reference, which a controller requires; replay the log without "
            "feeding a controller, and send a reference from elsewhere"
        )
    recorded: dict[int, tuple[float, ...]] = {}
    if commands is not None and commands.effort is not None:
        recorded = dict(zip(commands.stamp.tolist(), map(tuple, commands.effort.tolist()), strict=True))
    names = reference.names if commands is None else commands.names
    return ControllerFeed(_chunks(reference), names, recorded)


def _chunks(reference: JointSeries) -> tuple[ReferenceChunk, ...]:
    log_time = reference.stamp if reference.received is None else reference.received
    chunks = []
    for first in range(0, len(reference.stamp), CHUNK):
        rows = slice(first, first + CHUNK)
        stamps = reference.stamp[rows]

        def part(values: FloatArray | None, rows: slice = rows) -> FloatArray | None:
            return None if values is None else values[rows]

        chunk = JointTrajectoryChunk(
            int(stamps[0]),
            reference.names,
            stamps - stamps[0],
            positions=part(reference.position),
            velocities=part(reference.velocity),
            effort=part(reference.effort),
        )
        due = max(int(np.min(log_time[rows])) - LEAD, 0)
        chunks.append(ReferenceChunk(due, int(stamps[-1]), serialise_joint_trajectory(chunk)))
    return tuple(chunks)
