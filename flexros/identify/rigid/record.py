"""What the regression takes from a log: positions and torques of all motors on one time base."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.record.held_commands import EVEN, HeldCommands

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray
    from flexros.logs.time_series import JointSeries, Log
    from flexros.robot import Robot

_GAP = 1.5
"""Interval, in mean intervals, from which on samples are missing (chosen)."""


@dataclass(frozen=True, eq=False)
class RigidRecord:
    """Evenly sampled positions and torques.

    Attributes:
        sample_time: Interval [s].
        position: Motor positions [rad or m], shape (n, M).
        torque: Motor torques [Nm or N], shape (n, M).
        measured: Whether the torque was measured; else it is the command.
        warnings: What was noticed, one sentence each.
        first: Sample of the log with which it begins.
    """

    sample_time: float
    position: FloatArray
    torque: FloatArray
    measured: bool
    warnings: tuple[str, ...]
    first: int = 0


def rigid_record(log: Log, robot: Robot, label: str, hold: bool = False, first: int | None = None) -> RigidRecord:
    """Take positions and torques out of a log.

    The measured torque is preferred to the command. A command counts as the sample at the time of the position (eq.
    4.12), or, with `hold`, as what it is on average over one interval around that time, delayed as the robot file says
    and held until the next.

    Args:
        log: The log.
        robot: The robot, whose motors must be those of the log.
        label: Name of the log; opens error texts.
        hold: Take delay and hold of the command into account.
        first: Sample with which to begin; default: the first that has a torque. Before the first command there is none.

    Returns:
        The record.

    Raises:
        InputError: Joints do not fit, there is no torque, or samples are missing; the sentence says where.
    """
    states = log.joint_states
    if states.position is None:
        raise InputError(f"{label}: joint_states has no positions, which the regression needs; record them")
    columns = _columns(states, robot, f"{label}: joint_states")
    warnings: list[str] = []
    begin = 0
    if states.effort is not None:
        torque = states.effort[:, columns]
    elif log.joint_commands is not None and log.joint_commands.effort is not None:
        commands = log.joint_commands
        effort = commands.effort[:, _columns(commands, robot, f"{label}: joint_commands")]  # type: ignore[index]
        torque, begin = _acting(commands.stamp, effort, states.stamp, robot.delay, hold)
    else:
        raise InputError(
            f"{label} has neither measured torques (effort of joint_states) nor commanded ones (effort of "
            "joint_commands); record one of them"
        )
    first = begin if first is None else first
    _check_finite(states.position[:, columns], torque[first:], label)
    time = (states.stamp - states.stamp[0])[first:] * 1e-9
    interval, values = _even(time, np.hstack([states.position[first:, columns], torque[first:]]), label, warnings)
    _warn_of_limits(torque, robot, warnings)
    position, torque = values[:, : robot.n_motors], values[:, robot.n_motors :]
    return RigidRecord(interval, position, torque, states.effort is not None, tuple(warnings), first)


def _columns(series: JointSeries, robot: Robot, place: str) -> list[int]:
    """Places of the robot's motors among the joints of a series."""
    lacking = [name for name in robot.joint_names if name not in series.names]
    if lacking:
        raise InputError(
            f"{place} has the joints {', '.join(series.names)}, but robot {robot.name} has "
            f"{', '.join(robot.joint_names)}; give the robot of the log"
        )
    return [series.names.index(name) for name in robot.joint_names]


def _acting(
    command_stamp: IntArray, effort: FloatArray, stamp: IntArray, delay: float, hold: bool
) -> tuple[FloatArray, int]:
    """Commanded torque at the times of the positions, and the first row for which there is one."""
    start = command_stamp[0]
    begin, at = (command_stamp - start) * 1e-9, (stamp - start) * 1e-9
    if not hold:
        held = HeldCommands.of(command_stamp, stamp)
        return held.values(effort), held.first
    half = np.median(np.diff(at)) / 2
    begin = begin + delay
    ends = np.append(begin, max(begin[-1], at[-1]) + 2 * half)
    integral = np.vstack([np.zeros(effort.shape[1]), np.cumsum(np.diff(ends)[:, None] * effort, axis=0)])
    acting = np.empty((len(stamp), effort.shape[1]))
    for motor in range(effort.shape[1]):
        upper, lower = (np.interp(at + side, ends, integral[:, motor]) for side in (half, -half))
        acting[:, motor] = (upper - lower) / (2 * half)
    whole = at - half >= begin[0] - 1e-12
    return acting, int(np.argmax(whole)) if np.any(whole) else len(stamp)


def _check_finite(position: FloatArray, torque: FloatArray, label: str) -> None:
    for name, values in (("positions", position), ("torques", torque)):
        bad = np.flatnonzero(~np.all(np.isfinite(values), axis=1))
        if bad.size:
            raise InputError(
                f"{label}: {name} are not finite in {bad.size} samples, first in sample {bad[0]}; cut them out"
            )


def _even(time: FloatArray, values: FloatArray, label: str, warnings: list[str]) -> tuple[float, FloatArray]:
    """Return the interval, and the values at even times."""
    if len(time) < 2:
        raise InputError(f"{label} has {len(time)} samples with a torque; give a longer log")
    steps = np.diff(time)
    typical = float(np.median(steps))
    worst = int(np.argmax(steps))
    if steps[worst] > _GAP * typical:
        raise InputError(
            f"{label}: samples are missing at {time[worst]:.6g} s, where the interval is {1e3 * steps[worst]:.6g} ms "
            f"instead of {1e3 * typical:.6g} ms ({np.count_nonzero(steps > _GAP * typical)} such places); give a log "
            "without gaps"
        )
    interval = float((time[-1] - time[0]) / (len(time) - 1))
    even = time[0] + interval * np.arange(len(time))
    jitter = float(np.abs(even - time).max())
    if jitter <= EVEN * interval:
        return interval, values
    warnings.append(
        f"the samples are up to {1e3 * jitter:.3g} ms off an even interval of {1e3 * interval:.6g} ms; they were "
        "interpolated linearly"
    )
    columns = [np.interp(even, time, values[:, column]) for column in range(values.shape[1])]
    return interval, np.column_stack(columns)


def _warn_of_limits(torque: FloatArray, robot: Robot, warnings: list[str]) -> None:
    for motor, limit in enumerate(robot.torque_limits):
        count = int(np.count_nonzero(np.abs(torque[:, motor]) >= 0.999 * limit))
        if count:
            warnings.append(
                f"the torque of motor_{motor + 1} is at its limit of {limit:.6g} in {count} samples; what is beyond "
                "the limit is not in the log"
            )
