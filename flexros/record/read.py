"""The reader of logs: motors in their order, one even grid, what was repaired in words.

Diagnosis, rigid regression and the prediction of one axis take their samples from `read_record` by way of
`flexros.identify.log_record`, which says where a diagnosis goes further. Frequency responses, whose sampling instants
come from a plan, and the monitor, whose messages come one by one, follow the same rules with the same parts:
`torque_source`, `motor_columns`, `MOST_BRIDGED`, `NOTED_JITTER`, `LOWEST_RATE` and `HIGHEST_RATE`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.logs.stamps import START_NS
from flexros.logs.wrapped_positions import with_joined_positions
from flexros.record.even_grid import even_grid
from flexros.record.further_sensors import further_sensors
from flexros.record.joint_signs import joints_not_turned
from flexros.record.missing_samples import pauses, runs
from flexros.record.polled_source import recovered
from flexros.record.prescribed_motion import motors_named, with_prescribed_motion
from flexros.record.quantization import resolution_of
from flexros.record.record import Record, ToolRecord
from flexros.record.stamp_jitter import positions_on_grid
from flexros.record.topic_reader import Slots, TopicReader, has_position_commands, last_finite, torque_source
from flexros.record.torques.servo_torque import servo_torque
from flexros.record.torques.shifted_torque import HELD

if TYPE_CHECKING:
    from collections.abc import Collection

    from flexros.arrays import BoolArray, FloatArray
    from flexros.logs.time_series import Log
    from flexros.record.even_grid import EvenGrid
    from flexros.record.topic_reader import TorqueSource
    from flexros.record.torques.torque_hold import HeldTorque
    from flexros.robot import Robot

MOST_LOST = 0.3
"""Largest share of samples that may be missing or not finite (chosen)."""


def read_record(
    log: Log,
    robot: Robot,
    *,
    name: str,
    torque: TorqueSource = "command",
    positions: bool = False,
    prescribed: Collection[str] | None = None,
) -> Record:
    """Read positions, torques and what else was measured onto an even grid.

    Missing samples are held and marked. Positions with stamps that truly jitter are interpolated. Commands are held
    from stamp to stamp. A reference of another rate is interpolated linearly.

    Args:
        log: The log.
        robot: The nominal robot.
        name: Name of the log, for messages.
        torque: Torque that is taken where both were recorded; the other one is taken where it alone was.
        positions: Whether a log without torques is read where it has position commands, which the servos of the robot
            file follow.
        prescribed: Motors whose measured motion drives the model, whatever their torques; so it does where no torque
            of a motor was recorded. None: a log with torques of some motors alone is refused.

    Returns:
        The record; its warnings say what was repaired or is doubtful.

    Raises:
        InputError: There is no usable position or torque, or the joints do not fit the robot.
    """
    recorded = log.joint_states.position
    if recorded is None:
        raise InputError(f"{name}: joint_states has no positions; record them")
    warnings, imported = list(log.warnings), bool(log.provenance.get("import"))
    if not log.provenance.get("scenario"):
        log = with_joined_positions(log, warnings)
    if imported:
        log = recovered(log, warnings)
    reader = TopicReader(log, robot, name, warnings)
    drive = _drive(reader, torque, prescribed, servos=positions and has_position_commands(log))
    reader.spared = (*drive.asked, *drive.without_torque)
    grid = even_grid(log.joint_states.stamp, robot.sample_time, f"{name}: joint_states")
    warnings += grid.warnings
    position, valid, instants = positions_on_grid(reader.positions(), grid, name, warnings, reader.velocities())
    slots = Slots(grid, instants)
    record, rows = _motion_and_drive(reader, drive, slots, position, valid)
    record = _with_further_signals(record, reader, slots, rows)
    moved = log.joint_states.position is not recorded
    record = replace(
        record,
        simulated=bool(log.provenance.get("scenario")),
        imported=imported,
        thinned=_thinned(log),
        not_turned=joints_not_turned(log, robot),
        encoder_steps=_steps(recorded[:, reader.columns]) if instants or moved else (),
        warnings=tuple(dict.fromkeys(warnings)),
    )
    record = with_prescribed_motion(record, robot, drive.asked, "you ask for it")
    return with_prescribed_motion(record, robot, drive.without_torque, "no torque of it was recorded")


@dataclass(frozen=True)
class _Drive:
    """What drives the model of a log.

    Attributes:
        servos: Whether servos do, which follow position commands.
        source: The torque that acts otherwise.
        asked: Motors whose measured motion does, as was asked for.
        without_torque: Motors whose measured motion does, as no torque of them was recorded.
    """

    servos: bool
    source: TorqueSource
    asked: tuple[int, ...]
    without_torque: tuple[int, ...]


def _drive(reader: TopicReader, torque: TorqueSource, prescribed: Collection[str] | None, *, servos: bool) -> _Drive:
    """Choose what drives the model."""
    name, may_lack = reader.name, prescribed is not None
    source: TorqueSource = "command"
    if not servos:
        source = torque_source(reader.log, torque, reader.columns, name, reader.warnings, may_lack=may_lack)
    asked = motors_named(reader.robot, prescribed or ())
    if asked and servos:
        raise InputError(
            f"{name} has position commands and no torques, so that servos move every joint; prescribe none",
            "prescribed",
        )
    return _Drive(servos, source, asked, reader.without_torque(source) if may_lack and not servos else ())


def _motion_and_drive(
    reader: TopicReader, drive: _Drive, slots: Slots, position: FloatArray, valid: BoolArray
) -> tuple[Record, slice]:
    """Return positions with what drives the model, and the slots in which that is known."""
    grid = slots.grid
    held, measured = (reader.commanded(slots), False) if drive.servos else reader.torque(drive.source, slots)
    acting, finite = last_finite(held.torque)
    rows = slice(held.first, max(held.first, min(held.end, grid.n_slots)))
    known = (valid & held.known & finite)[rows]
    _count_lost(known, reader.name, reader.warnings)
    command = acting[rows] if drive.servos else None
    torque = acting[rows]
    if command is not None:
        torque = servo_torque(reader.robot, command, position[rows], grid.sample_time)
    begin = round(((grid.origin - START_NS) * 1e-9 + grid.start) / grid.sample_time)
    record = Record(
        name=reader.name,
        sample_time=grid.sample_time,
        position=position[rows],
        torque=torque,
        valid=known,
        late=held.late[rows] if held.late.any() else None,
        measured_torque=measured,
        noted=_noted(reader, held, torque, slots, rows, measured=measured) if command is None else None,
        torque_shift=0.0 if measured else HELD,
        command=command,
        first=begin + rows.start,
    )
    return record, rows


def _noted(
    reader: TopicReader, held: HeldTorque, torque: FloatArray, slots: Slots, rows: slice, *, measured: bool
) -> FloatArray | None:
    """Return the torques that were noted with the positions; where they are those that act, the same array."""
    if measured:
        return reader.measured(reader.log.joint_states.effort, slots, rows)
    if held.noted is held.torque:
        return torque
    return None if held.noted is None else last_finite(held.noted)[0][rows]


def _with_further_signals(record: Record, reader: TopicReader, slots: Slots, rows: slice) -> Record:
    """Add what was measured besides positions and torques."""
    log, states = reader.log, reader.log.joint_states
    sensors = further_sensors(log, reader.robot, reader.columns, slots.grid, rows, reader.name, reader.warnings)
    return replace(
        record,
        velocity=reader.measured(states.velocity, slots, rows),
        reference=reader.reference(slots.grid, rows),
        tool=_tool(log, slots.grid, rows),
        sensors=sensors,
        command_rate=None if record.command is None else reader.commanded_rate(slots, rows),
    )


def _thinned(log: Log) -> float:
    """Return how many commands the controller of a scenario gave for each one in the log; 1 where it is not known."""
    commands, period = log.joint_commands, log.provenance.get("sample_time")
    if commands is None or len(commands.stamp) < 2 or not isinstance(period, float) or period <= 0.0:
        return 1.0
    return float(np.median(np.diff(commands.stamp))) * 1e-9 / period


def _steps(position: FloatArray) -> tuple[float, ...]:
    """Return the resolution of each encoder as measured; 0 without one."""
    return tuple(resolution_of(column) for column in position.T)


def _count_lost(valid: BoolArray, name: str, warnings: list[str]) -> None:
    """Reject records of which too much is missing, pauses between experiments apart; report how much is."""
    pausing = pauses(valid)
    lost, paused = int(np.count_nonzero(~valid)), int(np.count_nonzero(pausing))
    if lost - paused > MOST_LOST * (len(valid) - paused):
        raise InputError(
            f"{name}: {lost} of {len(valid)} samples are missing or not finite (first at sample "
            f"{int(np.argmin(valid))}), allowed is a share of {MOST_LOST:g}; cut the log or record it without losses"
        )
    if paused:
        warnings.append(f"the log pauses {len(runs(pausing)[0])} times: its {paused} samples there do not count")
    lost -= paused
    if lost:
        warnings.append(
            f"{lost} of {len(valid)} samples are missing or not finite; the values before them are held there, and "
            "they do not count"
        )


def _tool(log: Log, grid: EvenGrid, rows: slice) -> ToolRecord | None:
    """Return the tool positions within the record, in its time."""
    series = log.tool_pose
    if series is None or rows.stop <= rows.start:
        return None
    time = (series.stamp - grid.origin) * 1e-9 - grid.instants[rows.start]
    last = (rows.stop - 1 - rows.start) * grid.sample_time
    inside = np.all(np.isfinite(series.position), axis=1) & (time > -1e-9) & (time < last + 1e-9)
    return ToolRecord(np.maximum(time[inside], 0.0), series.position[inside]) if inside.any() else None
