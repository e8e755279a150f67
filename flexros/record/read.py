"""The reader of logs: motors in their order, one even grid, what was repaired in words.

Diagnosis, rigid regression and the prediction of one axis take their samples from `read_record` by way of
`flexros.identify.log_record`, which says where a diagnosis goes further. Frequency responses, whose sampling instants
come from a plan, and the monitor, whose messages come one by one, follow the same rules with the same parts:
`torque_source`, `motor_columns`, `MOST_BRIDGED`, `NOTED_JITTER`, `LOWEST_RATE` and `HIGHEST_RATE`.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

import numpy as np

from flexros.errors import InputError
from flexros.logs.stamps import START_NS
from flexros.record.even_grid import even_grid
from flexros.record.further_sensors import further_sensors
from flexros.record.joint_columns import motor_columns
from flexros.record.missing_samples import pauses, runs
from flexros.record.polled_source import recovered
from flexros.record.prescribed_motion import motors_named, with_prescribed_motion
from flexros.record.quantization import resolution_of
from flexros.record.record import Record, ToolRecord
from flexros.record.servo_torque import servo_torque
from flexros.record.stamp_jitter import positions_on_grid
from flexros.record.torque_hold import held_torque, sampled_torque

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from flexros.arrays import BoolArray, FloatArray
    from flexros.logs.time_series import JointSeries, Log
    from flexros.record.even_grid import EvenGrid
    from flexros.record.torque_hold import HeldTorque
    from flexros.robot import Robot

TorqueSource = Literal["command", "measured"]
"""Which torque counts as the one that acted: that of joint_commands, or the effort of joint_states."""

MOST_LOST = 0.3
"""Largest share of samples that may be missing or not finite (chosen)."""

LEAST_REFERENCE = 0.9
"""Smallest share of the record that a reference must cover to be used (chosen)."""


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
    if log.joint_states.position is None:
        raise InputError(f"{name}: joint_states has no positions; record them")
    warnings = list(log.warnings)
    recorded = log.joint_states.position
    if log.provenance.get("import"):
        log = recovered(log, warnings)
    states = log.joint_states
    assert states.position is not None
    servos = positions and has_position_commands(log)
    reader = _Reader(log, robot, name, warnings)
    may_lack = prescribed is not None
    source = "command" if servos else torque_source(log, torque, reader.columns, name, warnings, may_lack=may_lack)
    named = motors_named(robot, prescribed or ())
    if named and servos:
        raise InputError(
            f"{name} has position commands and no torques, so that servos move every joint; prescribe none",
            "prescribed",
        )
    empty = () if servos or not may_lack else reader.without_torque(source)
    reader.spared = (*named, *empty)
    grid = even_grid(states.stamp, robot.sample_time, f"{name}: joint_states")
    warnings += grid.warnings
    position, valid, instants = positions_on_grid(states.position[:, reader.columns], grid, name, warnings)
    held, measured = (reader.commanded(grid, instants), False) if servos else reader.torque(source, grid, instants)
    valid &= held.known
    acting, finite = _finite(held.torque)
    valid &= finite
    rows = slice(held.first, max(held.first, min(held.end, grid.n_slots)))
    _count_lost(valid[rows], name, warnings)
    sensors = further_sensors(log, robot, reader.columns, grid, rows, name, warnings)
    command = acting[rows] if servos else None
    begin = round(((grid.origin - START_NS) * 1e-9 + grid.start) / grid.sample_time)
    record = Record(
        name=name,
        sample_time=grid.sample_time,
        position=position[rows],
        torque=acting[rows] if command is None else servo_torque(robot, command, position[rows], grid.sample_time),
        valid=valid[rows],
        late=held.late[rows] if held.late.any() else None,
        velocity=reader.measured(states.velocity, grid, rows, instants),
        effort=reader.measured(states.effort, grid, rows, instants),
        reference=reader.reference(grid, rows),
        tool=_tool(log, grid, rows),
        sensors=sensors,
        measured_torque=measured,
        command=command,
        command_rate=reader.commanded_rate(grid, rows, instants) if servos else None,
        simulated=bool(log.provenance.get("scenario")),
        imported=bool(log.provenance.get("import")),
        thinned=_thinned(log),
        encoder_steps=_steps(recorded[:, reader.columns]) if instants or states.position is not recorded else (),
        first=begin + rows.start,
        warnings=tuple(dict.fromkeys(warnings)),
    )
    record = with_prescribed_motion(record, robot, named, "you ask for it")
    return with_prescribed_motion(record, robot, empty, "no torque of it was recorded")


def _thinned(log: Log) -> float:
    """Return how many commands the controller of a scenario gave for each one in the log; 1 where it is not known."""
    commands, period = log.joint_commands, log.provenance.get("sample_time")
    if commands is None or len(commands.stamp) < 2 or not isinstance(period, float) or period <= 0.0:
        return 1.0
    return float(np.median(np.diff(commands.stamp))) * 1e-9 / period


def torque_source(
    log: Log,
    wanted: TorqueSource,
    columns: Sequence[int],
    name: str,
    warnings: list[str],
    *,
    may_lack: bool = False,
) -> TorqueSource:
    """Choose the torque of a log: the wanted one, or the other one where only that was recorded of all motors.

    Args:
        log: The log.
        wanted: Torque that is taken where both were recorded.
        columns: Column of each motor in joint_states, length M.
        name: Name of the log, for messages.
        warnings: Receives a sentence where the other one is taken.
        may_lack: Whether measured torques of some motors alone do, where none were commanded.

    Returns:
        The torque that was recorded.

    Raises:
        InputError: No torque was recorded, or that of some motors alone.
    """
    commands, states = log.joint_commands, log.joint_states
    commanded = commands is not None and commands.effort is not None
    effort = states.effort
    known = {states.names[i]: effort is not None and bool(np.isfinite(effort[:, i]).any()) for i in columns}
    measured = all(known.values()) or (may_lack and not commanded and any(known.values()))
    lacking = ", ".join(joint for joint, is_known in known.items() if not is_known)
    if not commanded and any(known.values()) and not measured:
        raise InputError(
            f"{name}: joint_states has no measured torque (effort) of {lacking}, and there are no commanded torques "
            "(effort of joint_commands); record one of them for all motors"
        )
    if not commanded and not measured:
        raise InputError(
            f"{name} has neither commanded torques (effort of joint_commands) nor measured ones (effort of "
            "joint_states); record one of them"
        )
    if wanted == "command" and not commanded:
        warnings.append("the log has no joint_commands; the measured torques of joint_states are used")
        return "measured"
    if wanted == "measured" and not measured:
        warnings.append(f"joint_states has no measured torques (effort) of {lacking}; the commanded torques are used")
        return "command"
    return wanted


def has_torques(log: Log) -> bool:
    """Whether torques were recorded, commanded or measured."""
    commands, states = log.joint_commands, log.joint_states
    commanded = commands is not None and commands.effort is not None and bool(np.any(np.isfinite(commands.effort)))
    return commanded or (states.effort is not None and bool(np.any(np.isfinite(states.effort))))


def position_commands(log: Log) -> tuple[str, JointSeries | None]:
    """Return the topic and the series of the commanded positions: joint_commands, else joint_reference."""
    for topic, series in (("joint_commands", log.joint_commands), ("joint_reference", log.joint_reference)):
        if series is not None and series.position is not None and np.any(np.isfinite(series.position)):
            return topic, series
    return "joint_commands", None


def has_position_commands(log: Log) -> bool:
    """Whether a log has position commands and no torques, so that servos are part of its model."""
    return not has_torques(log) and position_commands(log)[1] is not None


@dataclass
class _Reader:
    """Reads topics of a log in the order of the motors.

    Attributes:
        log: The log.
        robot: The nominal robot.
        name: Name of the log, for messages.
        warnings: Receives what was repaired or is doubtful.
        columns: Column of each motor in joint_states, length M.
        spared: Motors whose torque is not used.
    """

    log: Log
    robot: Robot
    name: str
    warnings: list[str]
    columns: list[int] = field(init=False)
    spared: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        self.columns = self._columns(self.log.joint_states.names, "joint_states", self.warnings)

    def _columns(
        self, names: tuple[str, ...], topic: str, warnings: list[str], states: tuple[str, ...] = ()
    ) -> list[int]:
        robot = self.robot
        return motor_columns(
            names, robot.joint_names, f"{self.name}: {topic}", warnings, owner=f"robot {robot.name}", states=states
        )

    def _columns_of(self, series: JointSeries, topic: str, warnings: list[str]) -> list[int]:
        """Match a topic to the motors, by the joint names of joint_states where it has them."""
        states = self.log.joint_states.names
        return self._columns(series.names, topic, warnings, tuple(states[column] for column in self.columns))

    def without_torque(self, source: TorqueSource) -> tuple[int, ...]:
        """List the motors of which no torque was recorded."""
        commands, effort = self.log.joint_commands, self.log.joint_states.effort
        columns = self.columns
        if source == "command":
            assert commands is not None
            effort, columns = commands.effort, self._columns_of(commands, "joint_commands", [])
        assert effort is not None
        return tuple(motor for motor, column in enumerate(columns) if not np.isfinite(effort[:, column]).any())

    def _of_motors(self, effort: FloatArray, columns: list[int]) -> FloatArray:
        """Return torques in the order of the motors, zero where they are not used."""
        torque: FloatArray = effort[:, columns]
        torque[:, list(self.spared)] = 0.0
        return torque

    def torque(self, source: TorqueSource, grid: EvenGrid, instants: bool) -> tuple[HeldTorque, bool]:
        """Return the torque of every slot, and whether it was measured."""
        commands, states = self.log.joint_commands, self.log.joint_states
        held = None
        if commands is not None and commands.effort is not None:
            columns = self._columns_of(commands, "joint_commands", self.warnings)
            held = held_torque(commands.stamp, self._of_motors(commands.effort, columns), grid, instants, states.stamp)
        if states.effort is not None and (held is None or np.any(np.isfinite(states.effort))):
            if held is not None and self._is_copy(states.effort, held, grid):
                self.warnings.append(
                    "the effort of joint_states is a copy of the commands, not a measurement; it is not used"
                )
            elif source == "measured":
                return sampled_torque(self._of_motors(states.effort, self.columns), grid, instants), True
            else:
                self.warnings.append(
                    "joint_states has measured torques too; the commanded torques are used, so actuator errors will "
                    "appear as a gap between robot and model"
                )
        assert held is not None
        if held.end - held.first < 2:
            raise InputError(
                f"{self.name}: no measurement is between the first and the last command, so the torques that acted "
                "are not known; check the time offset between joint_states and joint_commands"
            )
        self.warnings.extend(f"joint_commands: {text}" for text in held.warnings)
        return held, False

    def commanded(self, grid: EvenGrid, instants: bool) -> HeldTorque:
        """Return the commanded position of every slot."""
        try:
            self.robot.check_servos()
        except InputError as error:
            raise InputError(f"{self.name} has position commands and no torques, but {error}") from None
        topic, series = position_commands(self.log)
        assert series is not None
        assert series.position is not None
        columns = self._columns_of(series, topic, self.warnings)
        values = series.position[:, columns]
        held = held_torque(series.stamp, values, grid, instants, self.log.joint_states.stamp)
        if held.end - held.first < 2:
            raise InputError(
                f"{self.name}: no measurement is between the first and the last command; check the time offset between "
                f"joint_states and {topic}"
            )
        self.warnings.append(
            f"the log has no torques: the positions of {topic} are the commands, and the servos of the robot file are "
            "part of the model"
        )
        self.warnings.extend(f"{topic}: {text}" for text in held.warnings)
        return held

    def commanded_rate(self, grid: EvenGrid, rows: slice, instants: bool) -> FloatArray | None:
        """Return the commanded speed of every slot; None where it was not recorded."""
        topic, series = position_commands(self.log)
        if series is None or series.velocity is None or not np.all(np.isfinite(series.velocity)):
            return None
        values = series.velocity[:, self._columns_of(series, topic, [])]
        return held_torque(series.stamp, values, grid, instants, self.log.joint_states.stamp).torque[rows]

    def _is_copy(self, values: FloatArray, held: HeldTorque, grid: EvenGrid) -> bool:
        """Detect whether measured torques are the commands of the same sample or of the one before."""
        effort, command = values[:, self.columns][grid.rows], held.torque[grid.numbers]
        both = np.all(np.isfinite(effort), axis=1) & np.all(np.isfinite(command), axis=1) & held.known[grid.numbers]
        scale = float(np.abs(command[both]).max(initial=0.0))
        for shift in (0, 1):
            compared = both[shift:] & both[: len(both) - shift]
            difference = effort[shift:][compared] - command[: len(both) - shift][compared]
            if compared.any() and np.abs(difference).max() <= 1e-9 * scale:
                return True
        return False

    def measured(self, values: FloatArray | None, grid: EvenGrid, rows: slice, instants: bool) -> FloatArray | None:
        """Return a signal of joint_states by slot, missing values held; NaN for motors without; None without any."""
        if values is None:
            return None
        taken, held = values[grid.rows][:, self.columns], grid.held()[0]
        known = np.any(np.isfinite(taken), axis=0)
        signal = np.full((grid.n_slots, len(known)), np.nan)
        for motor in np.flatnonzero(known):
            column = taken[:, motor, None]
            signal[:, motor] = (grid.interpolated(column) if instants else _finite(column[held])[0])[:, 0]
        return signal[rows] if known.any() else None

    def reference(self, grid: EvenGrid, rows: slice) -> FloatArray | None:
        """Interpolate the reference positions onto the grid; None where there are none."""
        series = self.log.joint_reference
        if series is None or series.position is None:
            return None
        try:
            columns = self._columns_of(series, "joint_reference", [])
        except InputError:
            self.warnings.append("joint_reference has other joints than the robot; the reference is treated as unknown")
            return None
        values = series.position[:, columns]
        finite = np.all(np.isfinite(values), axis=1)
        time, at = ((series.stamp - grid.origin) * 1e-9)[finite], grid.instants[rows]
        covered = 0.0 if time.size < 2 else float(np.mean((at >= time[0] - 1e-9) & (at <= time[-1] + grid.sample_time)))
        if covered < LEAST_REFERENCE:
            self.warnings.append(
                f"joint_reference covers {100 * covered:.0f} % of the log, at least {100 * LEAST_REFERENCE:.0f} % are "
                "needed; the reference is treated as unknown"
            )
            return None
        if np.array_equal(series.stamp[finite], self.log.joint_states.stamp) and np.abs(grid.deviation).max() < 1e-9:
            return np.asarray(values[finite][grid.rows][grid.held()[0]][rows])
        return np.column_stack([np.interp(at, time, column) for column in values[finite].T])


def _steps(position: FloatArray) -> tuple[float, ...]:
    """Return the resolution of each encoder as measured; 0 without one."""
    return tuple(resolution_of(column) for column in position.T)


def _finite(values: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Replace rows that are not finite by the row before; also returns which rows are finite."""
    finite = np.all(np.isfinite(values), axis=1)
    if np.all(finite) or not np.any(finite):
        return np.nan_to_num(values), finite
    last = np.maximum.accumulate(np.where(finite, np.arange(len(values)), -1))
    return values[np.where(last < 0, np.argmax(finite), last)], finite


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
