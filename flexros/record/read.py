"""From a log to the record of a diagnosis: motors in their order, one even grid, what was repaired in words."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.logs.stamps import START_NS
from flexros.record.even_grid import even_grid
from flexros.record.joint_columns import motor_columns
from flexros.record.record import Record, ToolRecord
from flexros.record.stamp_jitter import positions_on_grid
from flexros.record.torque_hold import held_torque, sampled_torque

if TYPE_CHECKING:
    from flexros.arrays import BoolArray, FloatArray
    from flexros.logs.time_series import Log
    from flexros.record.even_grid import EvenGrid
    from flexros.record.torque_hold import HeldTorque
    from flexros.robot import Robot

MOST_LOST = 0.3
"""Largest share of samples that may be missing or not finite (chosen)."""

LEAST_REFERENCE = 0.9
"""Smallest share of the record that a reference must cover to be taken (chosen)."""


def read_record(log: Log, robot: Robot, *, name: str) -> Record:
    """Take out of a log what a diagnosis needs.

    Positions come from joint_states, torques from joint_commands (held from stamp to stamp), else the measured effort
    of joint_states. Missing samples are held and marked; positions with stamps that truly jitter are interpolated; a
    reference of another rate is interpolated linearly.

    Args:
        log: The log.
        robot: The nominal robot.
        name: Name of the log, for messages.

    Returns:
        The record; its warnings say what was repaired or is doubtful.

    Raises:
        InputError: There is no usable position or torque; the sentence says why.
    """
    states = log.joint_states
    if states.position is None:
        raise InputError(f"{name}: joint_states has no positions, without which there is no diagnosis; record them")
    warnings = list(log.warnings)
    columns = motor_columns(states.names, robot, f"{name}: joint_states", warnings)
    grid = even_grid(states.stamp, robot.sample_time, f"{name}: joint_states")
    warnings += grid.warnings
    position, valid, instants = positions_on_grid(states.position[:, columns], grid, name, warnings)
    held, measured = _torque(log, robot, grid, instants, name, warnings)
    valid &= held.known
    torque, finite = _finite(held.torque)
    valid &= finite
    rows = slice(held.first, max(held.first, min(held.end, grid.n_slots)))
    _count_lost(valid[rows], name, warnings)
    begin = round(((grid.origin - START_NS) * 1e-9 + grid.start) / grid.sample_time)
    return Record(
        name=name,
        sample_time=grid.sample_time,
        position=position[rows],
        torque=torque[rows],
        valid=valid[rows],
        late=held.late[rows] if held.late.any() else None,
        reference=_reference(log, robot, grid, rows, warnings),
        tool=_tool(log, grid, rows),
        measured_torque=measured,
        simulated=bool(log.provenance.get("scenario")),
        imported=bool(log.provenance.get("import")),
        first=begin + rows.start,
        warnings=tuple(dict.fromkeys(warnings)),
    )


def _torque(
    log: Log, robot: Robot, grid: EvenGrid, instants: bool, name: str, warnings: list[str]
) -> tuple[HeldTorque, bool]:
    """Take the commands, else the measured torques; also tells whether they are measured."""
    commands, states = log.joint_commands, log.joint_states
    if commands is not None and commands.effort is not None:
        columns = motor_columns(commands.names, robot, f"{name}: joint_commands", warnings)
        found = held_torque(commands.stamp, commands.effort[:, columns], grid, instants, states.stamp)
        if found.end - found.first < 2:
            raise InputError(
                f"{name}: no measurement lies between the first and the last command, so the torques that acted are "
                "not known; check the time offset between joint_states and joint_commands"
            )
        warnings += [f"joint_commands: {text}" for text in found.warnings]
        warnings += _measured_beside(log, robot, found, grid)
        return found, False
    if states.effort is None:
        raise InputError(
            f"{name} has neither commanded torques (effort of joint_commands) nor measured ones (effort of "
            "joint_states); record one of them"
        )
    columns = motor_columns(states.names, robot, f"{name}: joint_states", [])
    warnings.append("the log has no joint_commands; the measured torques of joint_states are taken as what acted")
    return sampled_torque(states.effort[:, columns], grid), True


def _measured_beside(log: Log, robot: Robot, held: HeldTorque, grid: EvenGrid) -> list[str]:
    """Say what measured torques beside the commands are: a copy of these, or something else that is not used."""
    states = log.joint_states
    if states.effort is None or not np.any(np.isfinite(states.effort)):
        return []
    effort = states.effort[:, motor_columns(states.names, robot, "joint_states", [])][grid.rows]
    command = held.torque[grid.numbers]
    both = np.all(np.isfinite(effort), axis=1) & np.all(np.isfinite(command), axis=1) & held.known[grid.numbers]
    scale = float(np.abs(command[both]).max(initial=0.0))
    for shift in (0, 1):
        there = both[shift:] & both[: len(both) - shift]
        difference = effort[shift:][there] - command[: len(both) - shift][there]
        if there.any() and np.abs(difference).max() <= 1e-9 * scale:
            return ["the effort of joint_states is a copy of the commands, no measurement; it is not used"]
    return ["the log has measured torques too; the commands are used, so whatever lies between both is seen as a gap"]


def _finite(torque: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Hold the torque before where one is not finite."""
    finite = np.all(np.isfinite(torque), axis=1)
    if np.all(finite) or not np.any(finite):
        return np.nan_to_num(torque), finite
    last = np.maximum.accumulate(np.where(finite, np.arange(len(torque)), -1))
    return torque[np.where(last < 0, np.argmax(finite), last)], finite


def _count_lost(valid: BoolArray, name: str, warnings: list[str]) -> None:
    """Refuse records of which too much is missing; say how much is."""
    lost = int(np.count_nonzero(~valid))
    if lost > MOST_LOST * len(valid):
        raise InputError(
            f"{name}: {lost} of {len(valid)} samples are missing or not finite (first at sample "
            f"{int(np.argmin(valid))}), allowed is a share of {MOST_LOST:g}; cut the log or record it without losses"
        )
    if lost:
        warnings.append(
            f"{lost} of {len(valid)} samples are missing or not finite; values before them are held there, and they "
            "do not count"
        )


def _reference(log: Log, robot: Robot, grid: EvenGrid, rows: slice, warnings: list[str]) -> FloatArray | None:
    """Interpolate the positions that were asked for onto the grid; None where there are none."""
    series = log.joint_reference
    if series is None or series.position is None:
        return None
    try:
        columns = motor_columns(series.names, robot, "joint_reference", [])
    except InputError:
        warnings.append("joint_reference has other joints than the robot, so the reference is taken as unknown")
        return None
    values = series.position[:, columns]
    finite = np.all(np.isfinite(values), axis=1)
    time, at = ((series.stamp - grid.origin) * 1e-9)[finite], grid.instants[rows]
    covered = 0.0 if time.size < 2 else float(np.mean((at >= time[0] - 1e-9) & (at <= time[-1] + grid.sample_time)))
    if covered < LEAST_REFERENCE:
        warnings.append(
            f"joint_reference covers {100 * covered:.0f} % of the log, needed are {100 * LEAST_REFERENCE:.0f} %; the "
            "reference is taken as unknown"
        )
        return None
    if np.array_equal(series.stamp[finite], log.joint_states.stamp) and np.abs(grid.deviation).max() < 1e-9:
        return np.asarray(values[finite][grid.rows][grid.held()[0]][rows])
    return np.column_stack([np.interp(at, time, column) for column in values[finite].T])


def _tool(log: Log, grid: EvenGrid, rows: slice) -> ToolRecord | None:
    """Take the tool positions within the record, in its time."""
    series = log.tool_pose
    if series is None or rows.stop <= rows.start:
        return None
    time = (series.stamp - grid.origin) * 1e-9 - grid.instants[rows.start]
    last = (rows.stop - 1 - rows.start) * grid.sample_time
    there = np.all(np.isfinite(series.position), axis=1) & (time > -1e-9) & (time < last + 1e-9)
    return ToolRecord(np.maximum(time[there], 0.0), series.position[there]) if there.any() else None
