"""Topics of a log: which of them drove the robot, and their signals in the order of the motors by slots of a grid."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

import numpy as np

from flexros.errors import InputError
from flexros.record.joint_columns import motor_columns
from flexros.record.torques.torque_hold import held_torque, sampled_torque

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import BoolArray, FloatArray
    from flexros.logs.time_series import JointSeries, Log
    from flexros.record.even_grid import EvenGrid
    from flexros.record.torques.torque_hold import HeldTorque
    from flexros.robot import Robot

TorqueSource = Literal["command", "measured"]
"""Which torque counts as the one that acted: that of joint_commands, or the effort of joint_states."""

LEAST_REFERENCE = 0.9
"""Smallest share of the record that a reference must cover to be used (chosen)."""


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
        lacking = "joint_commands" if commands is None else "commanded torques (effort of joint_commands)"
        warnings.append(f"the log has no {lacking}; the measured torques of joint_states are used")
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


@dataclass(frozen=True)
class Slots:
    """Slots of an even grid, and how values of samples come to them.

    Attributes:
        grid: The grid.
        instants: Whether signals are interpolated at its instants; else each sample fills its slot.
    """

    grid: EvenGrid
    instants: bool


@dataclass
class TopicReader:
    """Reads topics of a log in the order of the motors, onto the slots of an even grid.

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

    def columns_of(self, series: JointSeries, topic: str, warnings: list[str]) -> list[int]:
        """Match a topic to the motors, by the joint names of joint_states where it has them."""
        states = self.log.joint_states.names
        return self._columns(series.names, topic, warnings, tuple(states[column] for column in self.columns))

    def positions(self) -> FloatArray:
        """Return the measured positions of all motors [rad or m], shape (n, M)."""
        positions = self.log.joint_states.position
        assert positions is not None
        taken: FloatArray = positions[:, self.columns]
        return taken

    def velocities(self) -> FloatArray | None:
        """Return the measured velocities of all motors [rad/s or m/s], shape (n, M); None where there are none."""
        velocities = self.log.joint_states.velocity
        return None if velocities is None else velocities[:, self.columns]

    def without_torque(self, source: TorqueSource) -> tuple[int, ...]:
        """List the motors of which no torque was recorded."""
        commands, effort = self.log.joint_commands, self.log.joint_states.effort
        columns = self.columns
        if source == "command":
            assert commands is not None
            effort, columns = commands.effort, self.columns_of(commands, "joint_commands", [])
        assert effort is not None
        return tuple(motor for motor, column in enumerate(columns) if not np.isfinite(effort[:, column]).any())

    def _of_motors(self, effort: FloatArray, columns: list[int]) -> FloatArray:
        """Return torques in the order of the motors, zero where they are not used."""
        torque: FloatArray = effort[:, columns]
        torque[:, list(self.spared)] = 0.0
        return torque

    def torque(self, source: TorqueSource, slots: Slots) -> tuple[HeldTorque, bool]:
        """Return the torque of every slot, and whether it was measured."""
        grid, instants = slots.grid, slots.instants
        commands, states = self.log.joint_commands, self.log.joint_states
        held = None
        if commands is not None and commands.effort is not None:
            columns = self.columns_of(commands, "joint_commands", self.warnings)
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

    def commanded(self, slots: Slots) -> HeldTorque:
        """Return the commanded position of every slot."""
        try:
            self.robot.check_servos()
        except InputError as error:
            raise InputError(f"{self.name} has position commands and no torques, but {error}") from None
        topic, series = position_commands(self.log)
        assert series is not None
        assert series.position is not None
        columns = self.columns_of(series, topic, self.warnings)
        values = series.position[:, columns]
        held = held_torque(series.stamp, values, slots.grid, slots.instants, self.log.joint_states.stamp)
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

    def commanded_rate(self, slots: Slots, rows: slice) -> FloatArray | None:
        """Return the commanded speed of every slot; None where it was not recorded."""
        topic, series = position_commands(self.log)
        if series is None or series.velocity is None or not np.all(np.isfinite(series.velocity)):
            return None
        values = series.velocity[:, self.columns_of(series, topic, [])]
        held = held_torque(series.stamp, values, slots.grid, slots.instants, self.log.joint_states.stamp)
        return held.torque[rows]

    def _is_copy(self, values: FloatArray, held: HeldTorque, grid: EvenGrid) -> bool:
        """Detect whether measured torques are the commands of the same sample or of the one before."""
        effort, command = self._of_motors(values, self.columns)[grid.rows], held.torque[grid.numbers]
        both = np.all(np.isfinite(effort), axis=1) & np.all(np.isfinite(command), axis=1) & held.known[grid.numbers]
        scale = float(np.abs(command[both]).max(initial=0.0))
        for shift in (0, 1):
            compared = both[shift:] & both[: len(both) - shift]
            difference = effort[shift:][compared] - command[: len(both) - shift][compared]
            if compared.any() and np.abs(difference).max() <= 1e-9 * scale:
                return True
        return False

    def measured(self, values: FloatArray | None, slots: Slots, rows: slice) -> FloatArray | None:
        """Return a signal of joint_states by slot, missing values held; NaN for motors without; None without any."""
        if values is None:
            return None
        grid = slots.grid
        taken, held = values[grid.rows][:, self.columns], grid.held()[0]
        known = np.any(np.isfinite(taken), axis=0)
        signal = np.full((grid.n_slots, len(known)), np.nan)
        for motor in np.flatnonzero(known):
            column = taken[:, motor, None]
            signal[:, motor] = (grid.interpolated(column) if slots.instants else last_finite(column[held])[0])[:, 0]
        return signal[rows] if known.any() else None

    def reference(self, grid: EvenGrid, rows: slice) -> FloatArray | None:
        """Interpolate the reference positions onto the grid; None where there are none."""
        series = self.log.joint_reference
        if series is None or series.position is None:
            return None
        try:
            columns = self.columns_of(series, "joint_reference", [])
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


def last_finite(values: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Replace rows that are not finite by the row before; also return which rows are finite.

    Args:
        values: Values, shape (n, k).

    Returns:
        Finite values, shape (n, k), and whether a row was finite, shape (n,).
    """
    finite = np.all(np.isfinite(values), axis=1)
    if np.all(finite) or not np.any(finite):
        return np.nan_to_num(values), finite
    last = np.maximum.accumulate(np.where(finite, np.arange(len(values)), -1))
    return values[np.where(last < 0, np.argmax(finite), last)], finite
