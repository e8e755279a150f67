"""Friction torque at constant speeds, from logs of moves with a phase of constant speed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError, unknown_name

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray, IntArray
    from flexros.logs.time_series import Log

CONSTANT = 1e-3
"""Largest relative change of the reference speed in a phase of constant speed (chosen)."""

SHORTEST = 0.05
"""Shortest such phase [s] (chosen)."""

SETTLING = 0.3
"""Share of the phase at its beginning that is left out, in which the transient decays (chosen)."""


@dataclass(frozen=True, eq=False)
class FrictionPoints:
    """Torques at constant speeds.

    Attributes:
        speed: Mean speeds of the motor [rad/s or m/s], shape (n,).
        torque: Friction torques [Nm or N], shape (n,): without what does not change sign with the speed, if it was
            measured in both directions.
        spread: Standard deviations of the torque within each phase [Nm or N], shape (n,).
        offset: What does not change sign with the speed, such as gravity [Nm or N]; 0 if not known.
    """

    speed: FloatArray
    torque: FloatArray
    spread: FloatArray
    offset: float


def constant_speed_points(logs: Sequence[Log], joint: str) -> FrictionPoints:
    """Collect the phases of constant speed of all logs.

    Args:
        logs: Logs of moves at different speeds, with reference velocity and torque.
        joint: Name of the motor.

    Raises:
        InputError: No such joint, a signal is missing, or no phase of constant speed.
    """
    rows = [row for log in logs for row in _phases(log, joint)]
    if not rows:
        raise InputError(
            f"the logs have no phase of at least {SHORTEST:g} s in which the reference of {joint} moves at constant "
            "speed; record moves with a speed limit that they reach (time law bang_bang_snap)"
        )
    speed, torque, spread = np.array(rows).T
    forward, backward = speed > 0, speed < 0
    offset = 0.0
    if forward.any() and backward.any():
        offset = _offset(speed, torque)
    return FrictionPoints(speed, torque - offset, spread, offset)


def _offset(speed: FloatArray, torque: FloatArray) -> float:
    """Return the mean of opposite torques at equal sizes of speed, as far as both directions reach."""
    backward = np.argsort(-speed[speed < 0])
    sizes, opposite = -speed[speed < 0][backward], torque[speed < 0][backward]
    same = (speed > 0) & (speed >= sizes[0] * 0.99) & (speed <= sizes[-1] * 1.01)
    if not same.any():
        return 0.0
    return float(np.mean(0.5 * (torque[same] + np.interp(speed[same], sizes, opposite))))


def _phases(log: Log, joint: str) -> list[tuple[float, float, float]]:
    """Return mean speed, mean torque and its deviation of every phase of a log."""
    reference, command = log.joint_reference, log.joint_commands
    if reference is None or reference.velocity is None or command is None or command.effort is None:
        raise InputError(
            "a log has no reference velocity or no torque command; record joint_reference and joint_commands"
        )
    for series, topic in ((reference, "joint_reference"), (command, "joint_commands")):
        if joint not in series.names:
            raise unknown_name("joint", joint, series.names, topic)
    wanted = reference.velocity[:, reference.names.index(joint)]
    given = command.effort[:, command.names.index(joint)]
    known = np.isfinite(given)
    time = 1e-9 * (reference.stamp - reference.stamp[0])
    fastest = float(np.abs(wanted).max())
    if fastest == 0.0:
        return []
    steady = (np.abs(np.diff(wanted)) <= CONSTANT * 1e-2 * fastest) & (np.abs(wanted[1:]) > 1e-3 * fastest)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], steady, [False]]).astype(int)))
    found = []
    for first, stop in zip(edges[::2], edges[1::2], strict=True):
        if time[stop] - time[first] < SHORTEST:
            continue
        begin = time[first] + SETTLING * (time[stop] - time[first])
        torque = _between(command.stamp[known], given[known], reference.stamp[0], begin, time[stop])
        speed = wanted[first + 1 : stop + 1]
        if len(torque) and np.ptp(speed) <= CONSTANT * abs(float(speed.mean())):
            found.append((float(speed.mean()), float(torque.mean()), float(torque.std())))
    return found


def _between(stamp: IntArray, values: FloatArray, start: int, begin: float, end: float) -> FloatArray:
    time = 1e-9 * (stamp - start)
    return values[(time >= begin) & (time <= end)]
