"""Sensors of a log beside the motor encoders: behind the springs, in the joints and at the tool."""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.logs.time_series import ImuSeries, JointSeries
from flexros.record.joint_columns import motor_columns

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from flexros.arrays import FloatArray, IntArray
    from flexros.logs.time_series import Log
    from flexros.record.even_grid import EvenGrid
    from flexros.robot import Robot

FEWEST = 20
"""Least number of values of a sensor (chosen)."""


@dataclass(frozen=True)
class SensorQuantity:
    """A quantity that a further sensor measures.

    Attributes:
        topic: Topic of the log.
        field: Field of its time series.
        units: Units of a rotary and of a prismatic joint; the same of the tool.
    """

    topic: str
    field: str
    units: tuple[str, str]

    @property
    def of_tool(self) -> bool:
        """Whether it is measured at the tool, along an axis, instead of at a joint."""
        return self.topic == "tool_imu"


SENSOR_QUANTITIES: Mapping[str, SensorQuantity] = MappingProxyType(
    {
        "link position": SensorQuantity("link_states", "position", ("rad", "m")),
        "link speed": SensorQuantity("link_states", "velocity", ("rad/s", "m/s")),
        "joint torque": SensorQuantity("link_states", "effort", ("Nm", "N")),
        "tool acceleration": SensorQuantity("tool_imu", "acceleration", ("m/s2", "m/s2")),
        "tool turning rate": SensorQuantity("tool_imu", "turning_rate", ("rad/s", "rad/s")),
    }
)
"""Every quantity that a further sensor may measure, in the order in which the model yields them."""
AXES = ("x", "y", "z")


@dataclass(frozen=True, eq=False)
class SensorRecord:
    """One channel of a further sensor.

    Attributes:
        quantity: Name in `SENSOR_QUANTITIES`.
        place: Name of the motor whose joint it belongs to, or the axis of the tool: "x", "y" or "z".
        index: Number of that motor, or of that axis, from 0.
        unit: SI unit of its values.
        time: Times of its values since the first sample of the record [s], increasing, shape (m,); any rate.
        values: The values, shape (m,).
        motor: Position of the motor as its encoder showed it at these times [rad or m], shape (m,), for a link
            position; None for others.
    """

    quantity: str
    place: str
    index: int
    unit: str
    time: FloatArray
    values: FloatArray
    motor: FloatArray | None = None

    @property
    def of_tool(self) -> bool:
        """Whether it is measured at the tool, along an axis, instead of at a joint."""
        return SENSOR_QUANTITIES[self.quantity].of_tool

    @property
    def name(self) -> str:
        """Its name in messages, e.g. "joint torque of motor_1" or "tool acceleration along x"."""
        return f"{self.quantity} {'along' if self.of_tool else 'of'} {self.place}"

    def every(self, step: int) -> SensorRecord:
        """Keep every `step`-th value."""
        thin = slice(None, None, step)
        motor = None if self.motor is None else self.motor[thin]
        return replace(self, time=self.time[thin], values=self.values[thin], motor=motor)

    def part(self, begin: float, end: float) -> SensorRecord:
        """Cut out the values between two times; the time of the part starts at the first.

        Args:
            begin: First time [s].
            end: Last time [s].
        """
        inside = (self.time >= begin - 1e-9) & (self.time <= end + 1e-9)
        motor = None if self.motor is None else self.motor[inside]
        time = np.maximum(self.time[inside] - begin, 0.0)
        return replace(self, time=time, values=self.values[inside], motor=motor)


def further_sensors(
    log: Log, robot: Robot, columns: list[int], grid: EvenGrid, rows: slice, name: str, warnings: list[str]
) -> tuple[SensorRecord, ...]:
    """Read the sensors of a log beside the motor encoders, in the time of its record.

    Args:
        log: The log.
        robot: The nominal robot.
        columns: Column of each motor in joint_states, length M.
        grid: Even grid of the record.
        rows: Samples of the grid that the record holds.
        name: Name of the log, for messages.
        warnings: Receives what is left out.
    """
    if rows.stop <= rows.start:
        return ()
    found: list[SensorRecord] = []
    joints = tuple(log.joint_states.names[column] for column in columns)
    states = log.joint_states
    for quantity, place, index, sent, values in (*_of_joints(log, robot, joints, name, warnings), *_of_tool(log)):
        late = next((entry.delay for entry in robot.further_sensors if entry.quantity == quantity), 0.0)
        stamp, finite, motor = sent - round(late * 1e9), np.isfinite(values), None
        if quantity == "link position" and states.position is not None:
            motor = np.interp(stamp, states.stamp, states.position[:, columns[index]])
            finite &= np.isfinite(motor)
            motor = motor[finite]
        if not finite.any():
            continue
        rotary = SENSOR_QUANTITIES[quantity].of_tool or robot.motors[index].rotary
        sensor = SensorRecord(
            quantity,
            place,
            index,
            SENSOR_QUANTITIES[quantity].units[0 if rotary else 1],
            (stamp[finite] - grid.origin) * 1e-9 - grid.instants[rows.start],
            values[finite],
            motor,
        ).part(0.0, (rows.stop - 1 - rows.start) * grid.sample_time)
        if len(sensor.time) < FEWEST:
            warnings.append(f"{sensor.name}: {len(sensor.time)} values are within the log, {FEWEST} are needed")
        elif _is_copy(sensor):
            warnings.append(f"{sensor.name} is the position of its motor, not a measurement; it is not used")
        elif np.ptp(sensor.values) > 0:
            found.append(sensor)
    return tuple(found)


def _is_copy(sensor: SensorRecord) -> bool:
    """Return whether a link moves exactly as its motor does, as no two encoders see it."""
    moved = np.ptp(sensor.values)
    return sensor.motor is not None and bool(np.abs(sensor.values - sensor.motor).max() <= 1e-9 * moved and moved > 0)


def _of_joints(
    log: Log, robot: Robot, joints: tuple[str, ...], name: str, warnings: list[str]
) -> Iterator[tuple[str, str, int, IntArray, FloatArray]]:
    """List quantity, motor, its number, stamps and values of the sensors of the joints."""
    series = log.series("link_states")
    if not isinstance(series, JointSeries):
        return
    known = [joint for joint in robot.joint_names if joint in series.names]
    if not known:  # other names than those of the robot: as in joint_states, or all in their order
        try:
            order = motor_columns(
                series.names, robot.joint_names, f"{name}: link_states", warnings, owner=f"robot {robot.name}",
                states=joints,
            )  # fmt: skip
        except InputError as error:
            warnings.append(f"{error}; the sensors of link_states are not used")
            return
        columns = dict(zip(robot.joint_names, order))
    else:
        columns = {joint: series.names.index(joint) for joint in known}
    for quantity, entry in SENSOR_QUANTITIES.items():
        values = None if entry.of_tool else getattr(series, entry.field)
        if values is None:
            continue
        for motor, joint in enumerate(robot.joint_names):
            if joint in columns:
                yield quantity, joint, motor, series.stamp, values[:, columns[joint]]


def _of_tool(log: Log) -> Iterator[tuple[str, str, int, IntArray, FloatArray]]:
    """List quantity, axis, its number, stamps and values of the sensors at the tool."""
    series = log.series("tool_imu")
    if not isinstance(series, ImuSeries):
        return
    for quantity, entry in SENSOR_QUANTITIES.items():
        values = getattr(series, entry.field) if entry.of_tool else None
        if values is None:
            continue
        for index, axis in enumerate(AXES):
            yield quantity, axis, index, series.stamp, values[:, index]
